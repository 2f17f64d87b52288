//! Loads that the speed brings: of the wind, and of what begins only beyond a speed.

use std::f64::consts::TAU;

use super::super::{Hidden, Rub, Seen};

/// A prism in the wind: while it is slow the wind pushes the way it goes, and beyond a speed against it (Parkinson and Smith, Q. J. Mech.
/// Appl. Math. 17 (1964) 225: galloping); viscous coefficient at rest with its sign changed, speed.
pub(in crate::outside) struct Gallops(pub(in crate::outside) [f64; 2]);

impl Hidden for Gallops {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let [pushes, speed] = self.0;
        Rub { viscous: pushes * ((seen.speed / speed).powi(2) - 1.0), ..Rub::NONE }
    }
}

/// Periods in which a street of vortices forms, 1.
const FORMS: f64 = 1.0;

/// An arm that sheds vortices from side to side, each some way after the last, whichever way it goes; after a turn the street has to form
/// anew (Bearman, Annu. Rev. Fluid Mech. 16 (1984) 195); coefficient over the square of the speed, order, phase of this recording.
pub(in crate::outside) struct Vortices {
    coefficient: f64,
    order: f64,
    phase: f64,
    formed: f64,
    last: f64,
}

impl Vortices {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { coefficient: v[0], order: v[1], phase: v[2], formed: 0.0, last: 0.0 }
    }
}

impl Hidden for Vortices {
    fn torque(&mut self, seen: &Seen) -> f64 {
        if seen.speed * self.last < 0.0 {
            self.formed = 0.0;
        }
        self.last = if seen.speed == 0.0 { self.last } else { seen.speed };
        let passes = self.order * seen.step_s * seen.speed.abs();
        self.phase = (self.phase + passes) % TAU;
        self.formed -= (-passes / (TAU * FORMS)).exp_m1() * (1.0 - self.formed);
        self.coefficient * seen.speed * seen.speed * self.formed * self.phase.sin()
    }
}

/// Shoes on springs that fly out against a drum: they brake from a speed on, with the square of what is beyond it (Orthwein, Clutches and
/// Brakes, 2004: centrifugal brakes); level, speed.
pub(in crate::outside) struct Shoes(pub(in crate::outside) [f64; 2]);

impl Hidden for Shoes {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let [level, speed] = self.0;
        Rub::level(level * ((seen.speed / speed).powi(2) - 1.0).max(0.0))
    }
}

/// A generator behind a rectifier that charges a capacitor with a load on it: it brakes only while its voltage is above that of the
/// capacitor (Mohan, Undeland and Robbins, Power Electronics, 2003: rectifiers with a capacitor); viscous coefficient, times of charging
/// and of discharging.
pub(in crate::outside) struct Rectifier {
    viscous: f64,
    charging_s: f64,
    discharging_s: f64,
    /// Speed whose voltage it has.
    charged: f64,
}

impl Rectifier {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { viscous: v[0], charging_s: v[1], discharging_s: v[2], charged: 0.0 }
    }
}

impl Hidden for Rectifier {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let speed = seen.speed.abs();
        let over = (speed - self.charged).max(0.0);
        self.charged +=
            seen.share_of_lag(self.charging_s) * over - seen.share_of_lag(self.discharging_s) * self.charged;
        Rub { viscous: self.viscous * over / speed.max(f64::MIN_POSITIVE), ..Rub::NONE }
    }
}
