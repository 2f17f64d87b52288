//! A damper whose gap a thrust changes, and whose high voltage comes from the bus of the drive.

use super::super::{Hidden, Seen};

/// Discs that the thrust of helical teeth presses together, whichever way they drive: chains that are squeezed hold better (Tang, Zhang and
/// Tao, J. Appl. Phys. 87 (2000) 2634: structure-enhanced yield stress). What is nominal is half of that; share, torque.
pub(in crate::outside) struct ThrustSqueezes(pub(in crate::outside) [f64; 2]);

impl Hidden for ThrustSqueezes {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let [share, torque] = self.0;
        let pressed = (seen.drive / torque).powi(2);
        level * (1.0 + share * (pressed / (1.0 + pressed) - 0.5))
    }
}

/// One disc between two others, that the thrust moves: one way the torque closes its gap, the other way it opens it (Tang, Zhang and Tao, as
/// above); share, torque.
pub(in crate::outside) struct ThrustMoves(pub(in crate::outside) [f64; 2]);

impl Hidden for ThrustMoves {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let [share, torque] = self.0;
        level * (1.0 + share * (seen.drive / torque).tanh())
    }
}

/// A high voltage made from the bus of the drive, which sags while the drive takes power from it (Mohan, Undeland and Robbins, Power
/// Electronics, 2003: converters without regulation of the line). What is nominal is half of that; share, power.
pub(in crate::outside) struct BusSags(pub(in crate::outside) [f64; 2]);

impl Hidden for BusSags {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let [share, power_w] = self.0;
        let taken = (seen.drive * seen.speed).max(0.0) / power_w;
        level * (1.0 + share * (0.5 - taken / (1.0 + taken)))
    }
}

/// The same where braking pumps the bus up, until its load has used what came back (Mohan, Undeland and Robbins, as above: braking);
/// share, energy, time.
pub(in crate::outside) struct BusPumped {
    share: f64,
    energy_j: f64,
    time_s: f64,
    stored: f64,
}

impl BusPumped {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], energy_j: v[1], time_s: v[2], stored: 0.0 }
    }
}

impl Hidden for BusPumped {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let brakes = (-seen.drive * seen.speed).max(0.0);
        self.stored += seen.step_s * brakes / self.energy_j - seen.share_of_lag(self.time_s) * self.stored;
        level * (1.0 + self.share * self.stored / (1.0 + self.stored))
    }
}
