//! Springs that are not straight.

use super::{Hidden, Seen};

/// A stiff stop beyond an angle.
pub(super) struct EndStop(pub(super) [f64; 2]);

impl Hidden for EndStop {
    fn torque(&mut self, seen: &Seen) -> f64 {
        -self.0[0] * (seen.position - self.0[1]).max(0.0)
    }
}

/// A spring with free play about zero.
pub(super) struct GappedSpring(pub(super) [f64; 2]);

impl Hidden for GappedSpring {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let [stiffness, half] = self.0;
        -stiffness * (seen.position - seen.position.clamp(-half, half))
    }
}

/// A spring whose anchor creeps after the axis.
pub(super) struct CreepingSpring {
    stiffness: f64,
    time_s: f64,
    anchor: f64,
}

impl CreepingSpring {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { stiffness: v[0], time_s: v[1], anchor: 0.0 }
    }
}

impl Hidden for CreepingSpring {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let twist = seen.position - self.anchor;
        self.anchor += seen.share_of_lag(self.time_s) * twist;
        -self.stiffness * twist
    }
}
