//! What the dissipated power warms becomes weaker: `temperature_viscosity`, `temperature_yield`.
//!
//! One lumped heat store (Incropera and DeWitt, Fundamentals of Heat and Mass Transfer, ch. 5) takes the power P of all drag
//! and gives it off to its surroundings: dH/dt = P - r H, H the heat above the start, J. What it warms falls with its
//! temperature H / C as exp(-beta H / C) (Reynolds, Phil. Trans. 177 (1886) 157, for the viscosity of oil). Only the
//! product beta / C shows in a motion.

use super::friction::FASTEST_S;
use crate::Error;
use crate::model::not_negative;

/// A torque that falls with the heat in it; cold at the start of a run, where it has its nominal value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warming {
    /// Relative fall of the torque for each joule in the store, 1/J, not negative.
    pub per_j: f64,
    /// Share of the stored heat that is given off in a second, 1/s, not negative; one over R C.
    pub cooling_per_s: f64,
}

impl Warming {
    /// No store, or one without an effect.
    pub(crate) const NONE: Self = Self { per_j: 0.0, cooling_per_s: 0.0 };

    pub(crate) fn validate(&self, key: &str) -> Result<(), Error> {
        not_negative(&format!("{key}.per_j"), self.per_j)?;
        not_negative(&format!("{key}.cooling_per_s"), self.cooling_per_s)
    }

    /// Share of the cold torque that is left with `heat_j` in the store, 1.
    #[inline]
    pub fn share(&self, heat_j: f64) -> f64 {
        if self.per_j == 0.0 { 1.0 } else { (-self.per_j * heat_j).exp() }
    }

    /// Rate of the heat, W, under a dissipated power, W.
    #[inline]
    pub(crate) fn rate_w(&self, heat_j: f64, power_w: f64) -> f64 {
        power_w - self.followed_cooling_per_s() * heat_j
    }

    /// Heat `dt_s` later under a constant power, J, and what is left of the heat before, 1.
    #[inline]
    pub fn after(&self, heat_j: f64, power_w: f64, dt_s: f64) -> (f64, f64) {
        let cooled = self.followed_cooling_per_s() * dt_s;
        let kept = (-cooled).exp();
        let share = if cooled > 1e-9 { (1.0 - kept) / cooled } else { 1.0 };
        (kept * heat_j + share * power_w * dt_s, kept)
    }

    /// Longest step over which the heat is smooth, s.
    pub(crate) fn longest_step(&self, power_w: f64) -> f64 {
        (0.5 / (self.per_j * power_w + self.followed_cooling_per_s())).max(0.25 * FASTEST_S)
    }

    /// A store that cools faster has no heat to speak of.
    fn followed_cooling_per_s(&self) -> f64 {
        self.cooling_per_s.min(FASTEST_S.recip())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_settles_where_cooling_takes_the_power() {
        let warming = Warming { per_j: 0.01, cooling_per_s: 0.5 };
        let (heat_j, kept) = warming.after(3.0, 2.0, 0.8);
        let exact = 4.0 + (3.0 - 4.0) * f64::exp(-0.4);
        assert!((heat_j - exact).abs() < 1e-14 && (kept - f64::exp(-0.4)).abs() < 1e-15);
        assert!((warming.share(heat_j) - f64::exp(-0.01 * exact)).abs() < 1e-15);
        assert_eq!(Warming { cooling_per_s: 0.0, ..warming }.after(3.0, 2.0, 0.5).0, 4.0);
    }
}
