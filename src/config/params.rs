//! What a tick works with: a checked configuration, precomputed.

use super::{Config, ConfigError, IMAGE_PERIOD_S};
use crate::margins::Margins;
use crate::motion::MotionLimits;
use crate::units::{COUNTS_PER_POLE_PAIR, RAD_PER_COUNT};
use crate::{maths, parameters};

/// A sum over words that every single flipped bit, and every swap, changes: a rotation between additions.
macro_rules! sum_of {
    ($($word:expr),+ $(,)?) => {{
        let mut sum: u32 = 0x9e37_79b9;
        $(sum = sum.rotate_left(5).wrapping_add($word);)+
        sum
    }};
}

/// How the drive is brought to rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StopParams {
    pub(crate) on_disable: bool,
    pub(crate) on_link_loss: bool,
    pub(crate) torque_nm: f32,
    pub(crate) ticks: u32,
}

/// What [`crate::guard`] watches for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GuardParams {
    pub(crate) following_counts: u32,
    pub(crate) following_ticks: u32,
    pub(crate) over_speed_rad_s: f32,
    pub(crate) field_apart_kv_mm: f32,
    pub(crate) field_lag_gain: f32,
    pub(crate) field_apart_ticks: u32,
    pub(crate) hv_off_ticks: u32,
}

/// Commanded and monitored field may be apart for this long, s: three times the fluid's lag, for a field that is switched
/// fast.
const FIELD_APART_S: f32 = 0.02;
/// High voltage must be gone this long after it was switched off, s.
const HV_OFF_S: f32 = 0.1;

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
    pub(crate) exponent: [f32; 3],
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
    pub(crate) stop: StopParams,
    pub(crate) guard: GuardParams,
    motion: MotionLimits,
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
        if config.position_min_rad >= config.position_max_rad {
            let (min_rad, max_rad) = (config.position_min_rad, config.position_max_rad);
            return Err(ConfigError::Positions { min_rad, max_rad });
        }
        Ok(Self::precompute(config).sealed())
    }

    /// As [`Self::new`], for the image: refuses what it cannot do, and, unless `force`, what would be unstable or near it.
    ///
    /// # Errors
    /// As [`Self::new`]; another period than that of the image's timer, a speed from the converter, which the image does
    /// not read, margins under those `servo-lab tune` keeps.
    pub fn for_image(config: &Config, force: bool) -> Result<Self, ConfigError> {
        let params = Self::new(config)?;
        if config.period_s != IMAGE_PERIOD_S {
            return Err(ConfigError::BuiltIn { name: "period_s", only: IMAGE_PERIOD_S });
        }
        if config.speed_from_converter {
            return Err(ConfigError::BuiltIn { name: "speed_from_converter", only: 0.0 });
        }
        let margins = Margins::of(config);
        if force || margins.suffice(config) { Ok(params) } else { Err(ConfigError::Unstable(margins)) }
    }

    /// What bounds a reference from the link.
    pub fn motion(&self) -> &MotionLimits {
        &self.motion
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
            exponent: [config.er_q0, config.er_q1_s_rad, config.er_q2_s2_rad2],
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
            stop: StopParams {
                on_disable: config.stop_on_disable,
                on_link_loss: config.stop_on_link_loss,
                torque_nm: config.stop_torque_nm,
                ticks: ticks(config.stop_time_s),
            },
            guard: GuardParams {
                following_counts: (config.following_error_rad / RAD_PER_COUNT) as u32,
                following_ticks: ticks(config.following_time_s),
                over_speed_rad_s: config.over_speed_rad_s,
                field_apart_kv_mm: config.field_apart_kv_mm,
                field_lag_gain: 1.0 - maths::exp(-config.period_s / config.field_lag_s),
                field_apart_ticks: ticks(FIELD_APART_S),
                hv_off_ticks: ticks(HV_OFF_S),
            },
            motion: MotionLimits::of(config),
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

    // Straight on and without a loop: two instructions a word, in every tick.
    fn sum(&self) -> u32 {
        let flag = |flag: bool, bit: u32| u32::from(flag) << bit;
        let flags = flag(self.er_enabled, 0) | flag(self.hold, 1) | flag(self.speed_from_converter, 2);
        let flags = flags | flag(self.stop.on_disable, 3) | flag(self.stop.on_link_loss, 4);
        let (stop, guard, motion) = (&self.stop, &self.guard, &self.motion);
        let [q0, q1, q2] = self.exponent;
        sum_of!(
            self.kp_nm_count.to_bits(),
            self.kd_nm_s_rad.to_bits(),
            self.torque_limit_nm.to_bits(),
            self.inverse_a.to_bits(),
            self.half_b_over_a.to_bits(),
            q0.to_bits(),
            q1.to_bits(),
            q2.to_bits(),
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
            stop.torque_nm.to_bits(),
            stop.ticks,
            guard.following_counts,
            guard.following_ticks,
            guard.over_speed_rad_s.to_bits(),
            guard.field_apart_kv_mm.to_bits(),
            guard.field_lag_gain.to_bits(),
            guard.field_apart_ticks,
            guard.hv_off_ticks,
            motion.low.0 as u32,
            motion.high.0 as u32,
            motion.speed_counts.to_bits(),
            motion.acceleration_counts.to_bits(),
        )
    }
}
