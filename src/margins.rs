//! Stability margins of the linear loop, in closed form: what a set of parameters must keep before the image runs it.
//!
//! The loop of `servo-lab tune` without the fluid: (K_P + K_D s) e^(-sT) / (J s^2), where T is the delay of the motor
//! system and what the law adds to it: half a period for the hold, half a period and the low-pass for the speed estimate.
//! Its gain falls with frequency, so that one crossing decides.

use crate::Config;
use crate::maths;

/// Least phase margin, degrees: the default of `servo-lab tune`.
pub const PHASE_MARGIN_DEG: f32 = 30.0;
/// Least gain margin, a factor: the default of `servo-lab tune`.
pub const GAIN_MARGIN: f32 = 1.5;
/// Least delay margin as a share of `motor_delay_s`: the default of `servo-lab tune`.
pub const DELAY_MARGIN_SHARE: f32 = 0.2;

/// How far a loop is from unstable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margins {
    /// Phase margin, degrees; below 0 the loop is unstable.
    pub phase_deg: f32,
    /// Factor by which both gains may grow.
    pub gain: f32,
    /// Delay that may come on top, s.
    pub delay_s: f32,
}

impl Margins {
    /// Of the loop of a configuration whose values are in their ranges.
    pub fn of(config: &Config) -> Self {
        let (kp, kd, inertia) = (config.kp_nm_rad, config.kd_nm_s_rad, config.inertia_kg_m2);
        let estimate_s = if config.speed_from_converter { 0.0 } else { 0.5 * config.period_s + config.speed_filter_s };
        let delay_s = config.motor_delay_s + 0.5 * config.period_s + estimate_s;
        // |K_P + j w K_D| = J w^2.
        let damping = kd * kd;
        let crossing_rad_s =
            maths::sqrt((damping + maths::sqrt(damping * damping + 4.0 * (inertia * kp) * (inertia * kp))) / 2.0)
                / inertia;
        if crossing_rad_s <= 0.0 {
            // No gains, no loop.
            return Self { phase_deg: 90.0, gain: f32::MAX, delay_s: f32::MAX };
        }
        let phase_rad = lead_rad(kp, kd, crossing_rad_s) - crossing_rad_s * delay_s;
        Self {
            phase_deg: phase_rad.to_degrees(),
            gain: gain_margin(kp, kd, inertia, delay_s),
            delay_s: phase_rad / crossing_rad_s,
        }
    }

    /// Whether they are what a drive must keep.
    pub fn suffice(&self, config: &Config) -> bool {
        self.phase_deg >= PHASE_MARGIN_DEG
            && self.gain >= GAIN_MARGIN
            && self.delay_s >= DELAY_MARGIN_SHARE * config.motor_delay_s
    }
}

/// Phase lead of K_P + j w K_D, rad.
fn lead_rad(kp: f32, kd: f32, speed_rad_s: f32) -> f32 {
    if kp > 0.0 { libm::atanf(kd * speed_rad_s / kp) } else { core::f32::consts::FRAC_PI_2 }
}

/// Factor by which both gains may grow until the phase reaches -180 degrees at unit gain; 0 for a loop that never leads.
fn gain_margin(kp: f32, kd: f32, inertia: f32, delay_s: f32) -> f32 {
    // The lead is over w T up to one frequency only; w T reaches the most lead there is, a quarter turn, at `high`.
    let (mut low, mut high) = (0.0, core::f32::consts::FRAC_PI_2 / delay_s);
    // 40 halvings leave nothing of single precision.
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if lead_rad(kp, kd, middle) > middle * delay_s { low = middle } else { high = middle }
    }
    let gain = maths::sqrt(kp * kp + kd * low * (kd * low));
    if gain > 0.0 { inertia * low * low / gain } else { 0.0 }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{ConfigError, Params};

    #[test]
    fn the_paper_has_the_margins_of_the_specification() {
        // control.md section 6, where nothing but L delays: 42.5 degrees, 3.11, and 1.51 L more.
        let config = Config { period_s: 0.0, speed_filter_s: 0.0, ..Config::default() };
        let margins = Margins::of(&config);
        assert!((margins.phase_deg - 42.5).abs() < 0.1, "{margins:?}");
        assert!((margins.gain - 3.11).abs() < 0.01, "{margins:?}");
        assert!((margins.delay_s - 1.51 * 0.005).abs() < 2e-5, "{margins:?}");
    }

    #[test]
    fn the_defaults_are_run_and_what_is_unstable_is_refused_unless_forced() {
        let sound = Config::default();
        assert!(Params::for_image(&sound, false).is_ok(), "{:?}", Margins::of(&sound));
        let unstable = [
            Config { kd_nm_s_rad: 0.0, ..sound },
            Config { speed_filter_s: 0.1, ..sound },
            Config { kp_nm_rad: 5000.0, ..sound },
            Config { kd_nm_s_rad: 40.0, ..sound },
        ];
        for config in unstable {
            assert!(matches!(Params::for_image(&config, false), Err(ConfigError::Unstable(_))), "{config:?}");
            assert!(Params::for_image(&config, true).is_ok());
        }
    }

    #[test]
    fn what_is_built_into_the_image_cannot_be_forced() {
        let other = [
            Config { period_s: 0.002, ..Config::default() },
            Config { speed_from_converter: true, ..Config::default() },
        ];
        for config in other {
            assert!(Params::new(&config).is_ok(), "a host may");
            assert!(matches!(Params::for_image(&config, true), Err(ConfigError::BuiltIn { .. })), "{config:?}");
        }
    }
}
