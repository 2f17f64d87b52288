//! A damper whose drag goes with the time or with the acceleration.

use super::super::{Hidden, Seen};
use super::drive::wave;

/// A high voltage with hum; share, Hz, phase.
pub(in crate::outside) struct Hum(pub(in crate::outside) [f64; 3]);

impl Hidden for Hum {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        level * (1.0 + self.0[0] * wave(&self.0, seen))
    }
}

/// Fluid that the field makes solid turns with the rotor: an inertia with the drag. What is caught takes momentum, what is let go keeps
/// its own.
pub(in crate::outside) struct Bound {
    share: f64,
    half_level: f64,
    inertia: f64,
    caught: f64,
    catches: f64,
}

impl Bound {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], half_level: v[1], inertia: v[2], caught: 0.0, catches: 0.0 }
    }
}

impl Hidden for Bound {
    fn drag(&mut self, _: &Seen, level: f64) -> f64 {
        let caught = level / (level + self.half_level);
        self.catches = (caught - self.caught).max(0.0);
        self.caught = caught;
        level
    }

    fn torque(&mut self, seen: &Seen) -> f64 {
        -self.share * self.inertia * self.catches * seen.speed / seen.step_s
    }

    fn inertia(&self, _: &Seen) -> f64 {
        1.0 + self.share * self.caught
    }
}

/// Drag that is larger while the axis gains speed than while it loses it: the loop over the speed that dampers of such fluids show (Spencer
/// and others, J. Eng. Mech. 123 (1997) 230).
pub(in crate::outside) struct SpeedLoop {
    share: f64,
    time_s: f64,
    speed: f64,
    late: f64,
}

impl SpeedLoop {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], time_s: v[1], speed: v[2], late: 0.0 }
    }
}

impl Hidden for SpeedLoop {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let gained = seen.speed.abs() - self.late;
        self.late += seen.share_of_lag(self.time_s) * gained;
        level * (1.0 + self.share * (gained / self.speed).tanh())
    }
}
