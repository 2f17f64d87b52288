//! Damper, brake or off (Fig. 7 of the paper, control.md section 3).

use super::damper::field_for_damping_kv_mm;
use crate::maths::{self, Bounded};
use crate::{FIELD_CEILING_KV_MM, Faults, Limits, Params};

/// What the damper is used as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// No field.
    #[default]
    Off,
    /// Field from equations (4) and (5).
    Damper,
    /// Constant braking field.
    Brake,
}

impl Mode {
    /// Name in recordings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Damper => "damper",
            Self::Brake => "brake",
        }
    }
}

/// The mode for an error (reference minus position, counts) and a speed, in the order of the specification.
pub(crate) fn choose(params: &Params, error_counts: i32, speed_rad_s: f32) -> Mode {
    if !params.er_enabled || speed_rad_s.abs() > params.off_speed_rad_s {
        return Mode::Off;
    }
    // Within the dead-band the direction is one flickering count, so it is rest.
    let at_rest = speed_rad_s.abs() <= params.brake_deadband_rad_s;
    let moving_away = !at_rest && error_counts != 0 && (error_counts < 0) == (speed_rad_s > 0.0);
    let near = error_counts.unsigned_abs() < params.near_counts.unsigned_abs();
    if near && (moving_away || (params.hold && at_rest)) { Mode::Brake } else { Mode::Damper }
}

/// The field for a mode, kV/mm within 0 and the limit, with what bounded it.
pub(crate) fn field(params: &Params, mode: Mode, speed_rad_s: f32) -> (f32, Limits, Faults) {
    let wanted = match mode {
        Mode::Off => 0.0,
        Mode::Damper => field_for_damping_kv_mm(params, speed_rad_s),
        Mode::Brake => params.brake_field_kv_mm,
    };
    // The ceiling is a constant of the code: no damaged parameter can raise it.
    let (ceiling, _) = maths::limit(params.field_limit_kv_mm, 0.0, FIELD_CEILING_KV_MM);
    match maths::limit(wanted, 0.0, ceiling) {
        (field, Bounded::Above) => (field, Limits::FIELD_ABOVE, Faults::empty()),
        (field, Bounded::NotFinite) => (field, Limits::empty(), Faults::NOT_FINITE),
        (field, _) => (field, Limits::empty(), Faults::empty()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::Config;

    fn params(change: impl Fn(&mut Config)) -> Params {
        let mut config = Config { brake_deadband_rad_s: 0.0, ..Config::default() };
        change(&mut config);
        Params::new(&config).unwrap()
    }

    #[test]
    fn modes_follow_the_order_of_the_specification() {
        let strict = params(|_| ());
        let near = 1564; // 0.02 rad is 1564.6 counts
        let table = [
            (0, 1.6, Mode::Off),
            (0, -1.6, Mode::Off),
            (100, 1.5, Mode::Damper),
            (100, -0.1, Mode::Brake),
            (-100, 0.1, Mode::Brake),
            (-100, -0.1, Mode::Damper),
            (100, 0.0, Mode::Damper),
            (near, -0.1, Mode::Brake),
            (near + 1, -0.1, Mode::Damper),
            (-(near + 1), 0.1, Mode::Damper),
            (i32::MIN, 0.1, Mode::Damper),
        ];
        for (error, speed, mode) in table {
            assert_eq!(choose(&strict, error, speed), mode, "e {error} counts, w {speed} rad/s");
        }
    }

    #[test]
    fn hold_brakes_at_rest_and_the_deadband_is_rest() {
        let hold = params(|config| config.hold = true);
        assert_eq!(choose(&hold, 100, 0.0), Mode::Brake);
        assert_eq!(choose(&hold, 100, 0.01), Mode::Damper);
        let dead = params(|config| config.brake_deadband_rad_s = 0.0257);
        assert_eq!(choose(&dead, 100, -0.0257), Mode::Damper);
        assert_eq!(choose(&dead, 100, -0.0258), Mode::Brake);
    }

    #[test]
    fn er_off_is_off() {
        let off = params(|config| config.er_enabled = false);
        assert_eq!(choose(&off, 100, -0.1), Mode::Off);
    }
}
