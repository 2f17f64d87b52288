//! Configuration in SI units, and the parameters precomputed from it.

use crate::maths;
use crate::parameters::{self, Parameter};
use crate::units::{COUNTS_PER_POLE_PAIR, RAD_PER_COUNT};

/// What the law is built from. Names end in the unit; ranges stand in [`parameters::TABLE`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    /// Control period.
    pub period_s: f32,
    /// Proportional gain K_P.
    pub kp_nm_rad: f32,
    /// Velocity-feedback gain K_D.
    pub kd_nm_s_rad: f32,
    /// Torque command held within plus and minus this.
    pub torque_limit_nm: f32,
    /// False: the field stays at 0 whatever the motion.
    pub er_enabled: bool,
    /// a of equation (2), N m per (kV/mm)^2.
    pub er_a: f32,
    /// b of equation (2), N m per kV/mm.
    pub er_b: f32,
    /// c of equation (2): drag at zero field; the law needs it only to check `near_rad`.
    pub er_c_nm: f32,
    /// Field command held at or below this.
    pub field_limit_kv_mm: f32,
    /// Field of the brake.
    pub brake_field_kv_mm: f32,
    /// The brake acts only below this error; 0 turns it off.
    pub near_rad: f32,
    /// Measured speeds up to this count as rest for the brake; at least one count a sample, 0.0257, or it chatters.
    pub brake_deadband_rad_s: f32,
    /// The brake also holds at rest.
    pub hold: bool,
    /// Above this speed the field is off.
    pub off_speed_rad_s: f32,
    /// Time constant of the low-pass on the speed estimate; 0 for none.
    pub speed_filter_s: f32,
    /// Speed from the converter's own output in place of the difference of counts.
    pub speed_from_converter: bool,
    /// A faster reading is a jump.
    pub max_speed_rad_s: f32,
    /// A faster change of speed is a jump.
    pub max_acceleration_rad_s2: f32,
    /// Torque under which the rotor cannot stand still: over friction plus the highest ER torque.
    pub stale_torque_nm: f32,
    /// How long the counts may stand still under that torque; covers the delay of the motor system.
    pub stale_time_s: f32,
    /// Monitored field that trips the drive.
    pub field_trip_kv_mm: f32,
    /// From reset to ready: the converter settles in 20 ms.
    pub boot_time_s: f32,
}

impl Default for Config {
    /// The machine of the paper at L = 5 ms (control.md sections 1 to 4).
    fn default() -> Self {
        Self {
            period_s: 0.0005,
            kp_nm_rad: 240.0,
            kd_nm_s_rad: 6.96,
            torque_limit_nm: 30.0,
            er_enabled: true,
            er_a: 0.0704,
            er_b: 0.470,
            er_c_nm: 0.763,
            field_limit_kv_mm: 3.5,
            brake_field_kv_mm: 3.0,
            near_rad: 0.02,
            brake_deadband_rad_s: 0.0257,
            hold: false,
            off_speed_rad_s: 1.5,
            speed_filter_s: 0.001,
            speed_from_converter: false,
            max_speed_rad_s: 45.0,
            max_acceleration_rad_s2: 6500.0,
            stale_torque_nm: 4.0,
            stale_time_s: 0.02,
            field_trip_kv_mm: 3.8,
            boot_time_s: 0.02,
        }
    }
}

/// Why a [`Config`] is refused.
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
        }
    }
}

impl core::error::Error for ConfigError {}

/// A checked [`Config`] with everything a tick would otherwise compute; immutable, so that it can be swapped between two
/// ticks in one assignment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Params {
    pub(crate) kp_nm_count: f32,
    pub(crate) kd_nm_s_rad: f32,
    pub(crate) torque_limit_nm: f32,
    pub(crate) er_enabled: bool,
    pub(crate) inverse_a: f32,
    pub(crate) half_b_over_a: f32,
    pub(crate) field_limit_kv_mm: f32,
    pub(crate) brake_field_kv_mm: f32,
    pub(crate) near_counts: i32,
    pub(crate) brake_deadband_rad_s: f32,
    pub(crate) hold: bool,
    pub(crate) off_speed_rad_s: f32,
    pub(crate) rad_s_per_count: f32,
    pub(crate) speed_filter_gain: f32,
    pub(crate) speed_from_converter: bool,
    pub(crate) jump_counts: i32,
    pub(crate) jump_counts_change: i32,
    pub(crate) stale_torque_nm: f32,
    pub(crate) stale_ticks: u32,
    pub(crate) field_trip_kv_mm: f32,
    pub(crate) boot_ticks: u32,
    check: u32,
}

impl Params {
    /// Checks every value of `config` against its range and precomputes.
    ///
    /// # Errors
    /// The first value that is not finite or out of range, or a `near_rad` inside the error the brake can hold.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        for parameter in parameters::TABLE {
            let value = (parameter.get)(config);
            // Negated so that NaN is refused.
            if !(value >= parameter.min && value <= parameter.max) {
                return Err(ConfigError::OutOfRange { parameter, value });
            }
        }
        let field = config.brake_field_kv_mm;
        let brake_nm = config.er_c_nm + (config.er_a * field + config.er_b) * field;
        let brakes = config.er_enabled && config.near_rad > 0.0;
        if brakes && config.near_rad * config.kp_nm_rad <= brake_nm {
            return Err(ConfigError::NearTooSmall { near_rad: config.near_rad, held_rad: brake_nm / config.kp_nm_rad });
        }
        Ok(Self::precompute(config).sealed())
    }

    fn precompute(config: &Config) -> Self {
        let counts_per_rad_s = config.period_s / RAD_PER_COUNT;
        let jump = (config.max_speed_rad_s * counts_per_rad_s) as i32;
        let change = config.max_acceleration_rad_s2 * config.period_s * counts_per_rad_s;
        let ticks = |time_s: f32| (time_s / config.period_s + 0.5) as u32;
        let ratio = if config.speed_filter_s > 0.0 { config.period_s / config.speed_filter_s } else { f32::MAX };
        Self {
            kp_nm_count: config.kp_nm_rad * RAD_PER_COUNT,
            kd_nm_s_rad: config.kd_nm_s_rad,
            torque_limit_nm: config.torque_limit_nm,
            er_enabled: config.er_enabled,
            inverse_a: 1.0 / config.er_a,
            half_b_over_a: config.er_b / (2.0 * config.er_a),
            field_limit_kv_mm: config.field_limit_kv_mm,
            brake_field_kv_mm: config.brake_field_kv_mm,
            near_counts: (config.near_rad / RAD_PER_COUNT + 0.5) as i32,
            brake_deadband_rad_s: config.brake_deadband_rad_s,
            hold: config.hold,
            off_speed_rad_s: config.off_speed_rad_s,
            rad_s_per_count: 1.0 / counts_per_rad_s,
            speed_filter_gain: 1.0 - maths::exp(-ratio),
            speed_from_converter: config.speed_from_converter,
            // Half a pole pair is the furthest that can be told from a step back.
            jump_counts: jump.min(COUNTS_PER_POLE_PAIR / 2 - 1),
            jump_counts_change: change as i32 + 1,
            stale_torque_nm: config.stale_torque_nm,
            stale_ticks: ticks(config.stale_time_s),
            field_trip_kv_mm: config.field_trip_kv_mm,
            boot_ticks: ticks(config.boot_time_s),
            check: 0,
        }
    }

    fn sealed(mut self) -> Self {
        self.check = self.sum();
        self
    }

    /// Whether the parameters are still those that were checked: a flipped bit in RAM is a fault, not a gain.
    pub(crate) fn intact(&self) -> bool {
        self.check == self.sum()
    }

    fn sum(&self) -> u32 {
        let flags = u32::from(self.er_enabled) | u32::from(self.hold) << 1 | u32::from(self.speed_from_converter) << 2;
        [
            self.kp_nm_count.to_bits(),
            self.kd_nm_s_rad.to_bits(),
            self.torque_limit_nm.to_bits(),
            self.inverse_a.to_bits(),
            self.half_b_over_a.to_bits(),
            self.field_limit_kv_mm.to_bits(),
            self.brake_field_kv_mm.to_bits(),
            self.near_counts as u32,
            self.brake_deadband_rad_s.to_bits(),
            self.off_speed_rad_s.to_bits(),
            self.rad_s_per_count.to_bits(),
            self.speed_filter_gain.to_bits(),
            self.jump_counts as u32,
            self.jump_counts_change as u32,
            self.stale_torque_nm.to_bits(),
            self.stale_ticks,
            self.field_trip_kv_mm.to_bits(),
            self.boot_ticks,
            flags,
        ]
        .iter()
        // A rotation between additions makes every single flipped bit, and every swap, change the sum.
        .fold(0x9e37_79b9, |sum: u32, word| sum.rotate_left(5).wrapping_add(*word))
    }
}
