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
        self.excess += seen.share_of_lag(self.lag_s) * (wanted - self.excess);
        Rub::level(self.level * self.excess)
    }
}

/// Rolling bodies that deform before they roll: springs that slip one after another, so that the torque remembers where the axis
/// turned round (Prandtl's elements; Al-Bender and Symens, 2005, for rolling friction). All have slipped after the way.
pub(super) struct Rolling {
    level: f64,
    way: f64,
    torques: [f64; 4],
}

impl Rolling {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { level: v[0], way: v[1], torques: [0.0; 4] }
    }
}

impl Hidden for Rolling {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let (travel, most) = (seen.speed * seen.step_s, self.level / self.torques.len() as f64);
        for (index, torque) in self.torques.iter_mut().enumerate() {
            // The first slips after a sixteenth of the way.
            let way = self.way * 0.4_f64.powi(index as i32);
            *torque = (*torque + most * travel / way).clamp(-most, most);
        }
        -self.torques.iter().sum::<f64>()
    }
}

/// Balls that climb out of their groove after a turn, wedge, and settle as the nut moves on: a peak of friction some way after each
/// reversal.
pub(super) struct Wedged {
    level: f64,
    way: f64,
    travelled: f64,
    last: f64,
}

impl Wedged {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { level: v[0], way: v[1], travelled: 0.0, last: 0.0 }
    }
}

impl Hidden for Wedged {
    fn friction(&mut self, seen: &Seen) -> Rub {
        if seen.speed * self.last < 0.0 {
            self.travelled = 0.0;
        }
        // Rest is no turn.
        self.last = if seen.speed == 0.0 { self.last } else { seen.speed };
        self.travelled += seen.step_s * seen.speed.abs();
        let ways = self.travelled / self.way;
        Rub::level(self.level * ways * (1.0 - ways).exp())
    }
}

/// A film between a shaft and a bearing that do not share their centre: thin at some angles, thick at others.
pub(super) struct UnevenFilm(pub(super) [f64; 3]);

impl Hidden for UnevenFilm {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let [viscous, order, phase] = self.0;
        Rub { viscous: viscous * (1.0 + (order * seen.position + phase).sin()), ..Rub::NONE }
    }
}

/// Eddy currents in iron that turns in a field: a drag that grows with the speed, has its most at one and falls beyond (Smythe,
/// Trans. AIEE 61 (1942) 681).
pub(super) struct EddyBrake(pub(super) [f64; 2]);

impl Hidden for EddyBrake {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let [level, speed] = self.0;
        let ratio = seen.speed / speed;
        Rub { viscous: 2.0 * level / speed / (1.0 + ratio * ratio), ..Rub::NONE }
    }
}
