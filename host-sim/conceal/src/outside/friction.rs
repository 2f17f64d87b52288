//! Friction that depends on more than the direction and the speed.

use super::{Heat, Hidden, Rub, Seen, ramp};

/// A dry rub beyond an angle.
pub(super) struct RubZone(pub(super) [f64; 3]);

impl Hidden for RubZone {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let [level, from, width] = self.0;
        Rub::level(level * ramp(seen.position - from, width))
    }
}

/// Viscous friction that grows with the torque that the bearing carries.
pub(super) struct ViscousByLoad(pub(super) f64);

impl Hidden for ViscousByLoad {
    fn friction(&mut self, seen: &Seen) -> Rub {
        Rub { viscous: self.0 * seen.drive.abs(), ..Rub::NONE }
    }
}

/// Dry friction that falls as its own work warms it.
pub(super) struct DryWarms {
    share: f64,
    heat: Heat,
}

impl DryWarms {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { share: v[0], heat: Heat::new(v[1], v[2]) }
    }
}

impl Hidden for DryWarms {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let warm = self.heat.after((seen.drive * seen.speed).abs(), seen.step_s);
        Rub { share: 1.0 - self.share * warm, ..Rub::NONE }
    }
}

/// Grease: viscous when cold, thin when warm.
pub(super) struct GreaseWarms {
    coefficient: f64,
    heat: Heat,
}

impl GreaseWarms {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { coefficient: v[0], heat: Heat::new(v[1], v[2]) }
    }
}

impl Hidden for GreaseWarms {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let warm = self.heat.after((seen.drive * seen.speed).abs(), seen.step_s);
        Rub { viscous: self.coefficient * (1.0 - warm), ..Rub::NONE }
    }
}

/// A grip that is there after each rest or reversal and wears off with the way.
pub(super) struct Grip {
    level: f64,
    way: f64,
    travelled: f64,
    last: f64,
}

impl Grip {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { level: v[0], way: v[1], travelled: 0.0, last: 0.0 }
    }
}

impl Hidden for Grip {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let turned = seen.speed == 0.0 || seen.speed * self.last < 0.0;
        self.travelled = if turned { 0.0 } else { self.travelled + seen.step_s * seen.speed.abs() };
        self.last = seen.speed;
        Rub::level(self.level * (-self.travelled / self.way).exp())
    }
}

/// A rub that wears away with the whole way travelled.
pub(super) struct RunIn {
    level: f64,
    way: f64,
    travelled: f64,
}

impl RunIn {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { level: v[0], way: v[1], travelled: 0.0 }
    }
}

impl Hidden for RunIn {
    fn friction(&mut self, seen: &Seen) -> Rub {
        self.travelled += seen.step_s * seen.speed.abs();
        Rub::level(self.level * (-self.travelled / self.way).exp())
    }
}

/// A seal that seats at an instant of each recording: more rub from then on.
pub(super) struct Seats(pub(super) [f64; 3]);

impl Hidden for Seats {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let [level, at_s, width_s] = self.0;
        Rub::level(level * ramp(seen.t_s - at_s, width_s))
    }
}

/// Dry friction that a film carries away as the speed grows.
pub(super) struct Film(pub(super) [f64; 2]);

impl Hidden for Film {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let [share, speed] = self.0;
        let squared = seen.speed * seen.speed;
        Rub { share: 1.0 - share * squared / (squared + speed * speed), ..Rub::NONE }
    }
}

/// Drag with the root of the speed.
pub(super) struct RootDrag(pub(super) [f64; 2]);

impl Hidden for RootDrag {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let [coefficient, least] = self.0;
        Rub { viscous: coefficient / (seen.speed.abs() + least).sqrt(), ..Rub::NONE }
    }
}

/// Stribeck's excess that follows the speed late.
pub(super) struct LateStribeck {
    level: f64,
    speed: f64,
    lag_s: f64,
    excess: f64,
}

impl LateStribeck {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { level: v[0], speed: v[1], lag_s: v[2], excess: 1.0 }
    }
}

impl Hidden for LateStribeck {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let wanted = (-(seen.speed / self.speed).powi(2)).exp();
        self.excess += -(-seen.step_s / self.lag_s).exp_m1() * (wanted - self.excess);
        Rub::level(self.level * self.excess)
    }
}
