//! A damper whose high voltage has two polarities.

use std::f64::consts::TAU;

use super::super::{Hidden, Seen};

/// Shares of the full field above which it is on, and below which it is off again, 1.
const ON: f64 = 0.4;
const OFF: f64 = 0.2;

/// A supply that takes the other polarity each time the field comes on, so that nothing is drawn to one electrode for long; the fluid holds
/// better with one than with the other (Jordan and Shaw, IEEE Trans. Electr. Insul. 24 (1989) 849: fluids under steady and alternating
/// fields); difference, full field.
pub(in crate::outside) struct PolesDiffer {
    difference: f64,
    full_kv_mm: f64,
    on: bool,
    pole: f64,
}

impl PolesDiffer {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { difference: v[0], full_kv_mm: v[1], on: false, pole: -1.0 }
    }
}

impl Hidden for PolesDiffer {
    fn field(&mut self, field_kv_mm: f64) -> f64 {
        let on = field_kv_mm > self.full_kv_mm * if self.on { OFF } else { ON };
        if on && !self.on {
            self.pole = -self.pole;
        }
        self.on = on;
        field_kv_mm
    }

    fn drag(&mut self, _: &Seen, level: f64) -> f64 {
        level * (1.0 + 0.5 * self.difference * self.pole)
    }
}

/// A supply that reverses its polarity on a clock: each time the field goes through nothing, and the chains have to form again (Jordan and
/// Shaw, as above); share, time between reversals, phase of this recording, time of forming.
pub(in crate::outside) struct PolarityFlips(pub(in crate::outside) [f64; 4]);

impl Hidden for PolarityFlips {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let [share, between_s, phase, forming_s] = self.0;
        let since_s = ((seen.t_s + 0.5 * seen.step_s) / between_s + phase / TAU).rem_euclid(1.0) * between_s;
        level * (1.0 - share * (-since_s / forming_s).exp())
    }
}
