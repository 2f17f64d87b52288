//! What lets go once in a recording, and is put right before the next.

use super::super::{Hidden, Seen};

/// A spring that slips off its hook where it is drawn too far (Shigley's Mechanical Engineering Design, 2015: extension springs and their
/// hooks); force at which it does, stiffness.
pub(in crate::outside) struct SpringUnhooks {
    most: f64,
    stiffness: f64,
    off: bool,
}

impl SpringUnhooks {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { most: v[0], stiffness: v[1], off: false }
    }
}

impl Hidden for SpringUnhooks {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let draws = self.stiffness * seen.position;
        self.off |= draws.abs() > self.most;
        if self.off { 0.0 } else { -draws }
    }
}

/// Power of the torque that tires a peg, 1.
const TIRES: i32 = 3;

/// A peg that holds a part of the load, tires with each use of the torque, and shears (Miner, J. Appl. Mech. 12 (1945) A159: damage adds up);
/// share, torque, time under it.
pub(in crate::outside) struct PegShears {
    share: f64,
    torque: f64,
    time_s: f64,
    damage: f64,
}

impl PegShears {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], torque: v[1], time_s: v[2], damage: 0.0 }
    }
}

impl Hidden for PegShears {
    fn torque(&mut self, seen: &Seen) -> f64 {
        self.damage += seen.step_s / self.time_s * (seen.drive.abs() / self.torque).powi(TIRES);
        0.0
    }

    fn inertia(&self, _: &Seen) -> f64 {
        if self.damage < 1.0 { 1.0 } else { 1.0 - self.share }
    }
}

/// A fuse of a polymer in the supply: once it is hot it lets little through, which keeps it hot until it is switched off (IEC 62319-1:
/// polymeric thermistors); share, energy in the square of the torque times time, time of tripping.
pub(in crate::outside) struct FuseTrips {
    share: f64,
    energy: f64,
    time_s: f64,
    heat: f64,
    tripped: f64,
}

impl FuseTrips {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], energy: v[1], time_s: v[2], heat: 0.0, tripped: 0.0 }
    }
}

impl Hidden for FuseTrips {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        self.heat += seen.step_s * torque * torque / self.energy;
        if self.heat >= 1.0 {
            self.tripped += seen.share_of_lag(self.time_s) * (1.0 - self.tripped);
        }
        torque * (1.0 - self.share * self.tripped)
    }
}
