//! Friction that goes with the load, here more and there less.

use super::super::{Hidden, Rub, Seen};

/// Gears that are not round: their teeth lose a share of the torque that goes with how deep they mesh at this angle (Niemann and Winter,
/// Maschinenelemente 2, 2003: run-out of gears and losses of the mesh); share, order, phase.
pub(in crate::outside) struct EccentricMesh(pub(in crate::outside) [f64; 3]);

impl Hidden for EccentricMesh {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let [share, order, phase] = self.0;
        Rub::level(share * seen.drive.abs() * (1.0 + (order * seen.position + phase).sin()))
    }
}

/// A slide that is driven from its side and hangs over its guide beyond a place: it cants and rubs by the force times the overhang, as a
/// drawer that jams (Slocum, Precision Machine Design, 1992: ratio of guides); share at one way beyond, place, way.
pub(in crate::outside) struct DrawerJams(pub(in crate::outside) [f64; 3]);

impl Hidden for DrawerJams {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let [share, at, way] = self.0;
        let overhang = ((seen.position - at) / way).max(0.0);
        Rub::level((share * overhang).min(0.95) * seen.drive.abs())
    }
}
