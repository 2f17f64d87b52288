//! Why a configuration is refused, in words that say what is allowed.

use crate::margins::{DELAY_MARGIN_SHARE, GAIN_MARGIN, Margins, PHASE_MARGIN_DEG};
use crate::parameters::Parameter;

/// Why a [`crate::Config`] is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ConfigError {
    /// A value is not finite or lies outside its range.
    OutOfRange {
        /// The parameter, with its unit and range.
        parameter: &'static Parameter,
        /// What was asked for.
        value: f32,
    },
    /// The brake would let go inside the error it can hold.
    NearTooSmall {
        /// What was asked for, rad.
        near_rad: f32,
        /// The error the brake holds, (c + a E^2 + b E)/K_P, rad.
        held_rad: f32,
    },
    /// The lowest position is not below the highest.
    Positions {
        /// Lowest, rad.
        min_rad: f32,
        /// Highest, rad.
        max_rad: f32,
    },
    /// The image has this value built in.
    BuiltIn {
        /// Name of the parameter.
        name: &'static str,
        /// The only value the image runs with.
        only: f32,
    },
    /// The loop would be unstable, or too near to it.
    Unstable(Margins),
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::OutOfRange { parameter: p, value } => {
                write!(f, "{}: {value} {} is not allowed, {} to {} is", p.name, p.unit, p.min, p.max)
            }
            Self::NearTooSmall { near_rad, held_rad } => write!(
                f,
                "near_rad: {near_rad} rad is not allowed at this gain, 0 (no brake) or more than {held_rad} is, \
                 the error the brake can hold"
            ),
            Self::Positions { min_rad, max_rad } => {
                write!(f, "position_min_rad: {min_rad} rad is not allowed, less than position_max_rad ({max_rad}) is")
            }
            Self::BuiltIn { name, only } => write!(f, "{name}: built into the image, only {only} is allowed"),
            Self::Unstable(margins) => write!(
                f,
                "kp_nm_rad, kd_nm_s_rad, speed_filter_s: margins too small: phase {:.1} degrees (at least \
                 {PHASE_MARGIN_DEG}), gain {:.2} (at least {GAIN_MARGIN}), delay {:.2} ms (at least {DELAY_MARGIN_SHARE} of \
                 motor_delay_s); raise kd_nm_s_rad, lower kp_nm_rad or the filter, or force it",
                margins.phase_deg,
                margins.gain,
                1e3 * margins.delay_s
            ),
        }
    }
}

impl core::error::Error for ConfigError {}
