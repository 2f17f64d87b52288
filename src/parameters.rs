//! The one table of parameters: names, units and ranges for the machine file, the command link and the flash.

use crate::Config;

/// One entry of [`TABLE`].
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Key in the machine file's `[controller]` section and on the command link.
    pub name: &'static str,
    /// Unit of the value; `flag` for 0 or 1.
    pub unit: &'static str,
    /// Smallest value allowed.
    pub min: f32,
    /// Largest value allowed.
    pub max: f32,
    /// Reads the value; a flag reads as 0 or 1.
    pub get: fn(&Config) -> f32,
    /// Writes the value unchecked; a flag is set by anything but 0. [`crate::Params::new`] checks.
    pub set: fn(&mut Config, f32),
}

impl PartialEq for Parameter {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

macro_rules! number {
    ($name:ident, $unit:literal, $min:expr, $max:expr) => {
        Parameter {
            name: stringify!($name),
            unit: $unit,
            min: $min,
            max: $max,
            get: |config| config.$name,
            set: |config, value| config.$name = value,
        }
    };
}

macro_rules! flag {
    ($name:ident) => {
        Parameter {
            name: stringify!($name),
            unit: "flag",
            min: 0.0,
            max: 1.0,
            get: |config| if config.$name { 1.0 } else { 0.0 },
            set: |config, value| config.$name = value != 0.0,
        }
    };
}

/// Every parameter; the order is the index on the command link and in flash, so new ones go to the end.
pub static TABLE: &[Parameter] = &[
    number!(period_s, "s", 1e-4, 2e-3),
    number!(kp_nm_rad, "N m/rad", 0.0, 5000.0),
    number!(kd_nm_s_rad, "N m s/rad", 0.0, 200.0),
    number!(torque_limit_nm, "N m", 0.0, crate::TORQUE_CEILING_NM),
    flag!(er_enabled),
    number!(er_a, "N m mm2/kV2", 1e-3, 10.0),
    number!(er_b, "N m mm/kV", 0.0, 100.0),
    number!(er_c_nm, "N m", 0.0, 30.0),
    number!(field_limit_kv_mm, "kV/mm", 0.0, crate::FIELD_CEILING_KV_MM),
    number!(brake_field_kv_mm, "kV/mm", 0.0, crate::FIELD_CEILING_KV_MM),
    number!(near_rad, "rad", 0.0, 1.0),
    number!(brake_deadband_rad_s, "rad/s", 0.0, 1.5),
    flag!(hold),
    // Equation (5) is a fit below 1.5 rad/s; above 1.26 it already rises again.
    number!(off_speed_rad_s, "rad/s", 0.01, 1.5),
    number!(speed_filter_s, "s", 0.0, 0.1),
    flag!(speed_from_converter),
    // Beyond 52.3 rad/s the 12-bit converter no longer tracks and a tick spans half a pole pair.
    number!(max_speed_rad_s, "rad/s", 1.0, 52.0),
    number!(max_acceleration_rad_s2, "rad/s2", 400.0, 1e5),
    number!(stale_torque_nm, "N m", 3.3, 30.0),
    number!(stale_time_s, "s", 0.001, 1.0),
    number!(field_trip_kv_mm, "kV/mm", 3.5, 4.0),
    number!(boot_time_s, "s", 0.02, 10.0),
    number!(inertia_kg_m2, "kg m2", 1e-4, 100.0),
    number!(motor_delay_s, "s", 0.0, 0.1),
    number!(following_error_rad, "rad", 0.001, 100.0),
    number!(following_time_s, "s", 0.01, 10.0),
    number!(over_speed_rad_s, "rad/s", 0.1, 52.0),
    number!(field_apart_kv_mm, "kV/mm", 0.2, 4.0),
    number!(field_lag_s, "s", 0.0005, 0.1),
    number!(position_min_rad, "rad", -crate::config::POSITION_RANGE_RAD, crate::config::POSITION_RANGE_RAD),
    number!(position_max_rad, "rad", -crate::config::POSITION_RANGE_RAD, crate::config::POSITION_RANGE_RAD),
    number!(speed_limit_rad_s, "rad/s", 0.01, 50.0),
    number!(acceleration_limit_rad_s2, "rad/s2", 0.1, 400.0),
    flag!(stop_on_disable),
    flag!(stop_on_link_loss),
    number!(stop_torque_nm, "N m", 0.0, crate::TORQUE_CEILING_NM),
    number!(stop_time_s, "s", 0.01, 5.0),
    // Up to 1.5 rad/s, where the field goes off, no exponent within these leaves single precision.
    number!(er_q0, "ln(N m s/rad)", -20.0, 12.0),
    number!(er_q1_s_rad, "s/rad", -20.0, 8.0),
    number!(er_q2_s2_rad2, "s2/rad2", -8.0, 8.0),
];

/// The parameter of that name.
pub fn find(name: &str) -> Option<&'static Parameter> {
    TABLE.iter().find(|parameter| parameter.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ConfigError, Params};

    #[test]
    fn defaults_are_inside_their_ranges_and_every_entry_reads_what_it_wrote() {
        assert!(Params::new(&Config::default()).is_ok());
        for parameter in TABLE {
            let mut config = Config::default();
            (parameter.set)(&mut config, parameter.max);
            assert_eq!((parameter.get)(&config), parameter.max, "{}", parameter.name);
        }
    }

    #[test]
    fn each_value_outside_its_range_is_refused_by_name() {
        for parameter in TABLE.iter().filter(|parameter| parameter.unit != "flag") {
            for bad in [f32::NAN, f32::INFINITY, parameter.min - 1.0, parameter.max * 2.0 + 1.0] {
                let mut config = Config::default();
                (parameter.set)(&mut config, bad);
                match Params::new(&config) {
                    Err(ConfigError::OutOfRange { parameter: named, .. }) => assert_eq!(named.name, parameter.name),
                    other => assert!(other.is_err(), "{} took {bad}", parameter.name),
                }
            }
        }
    }

    #[test]
    fn a_brake_that_cannot_hold_is_refused() {
        let config = Config { near_rad: 0.0116, ..Config::default() };
        assert!(matches!(Params::new(&config), Err(ConfigError::NearTooSmall { .. })));
        assert!(Params::new(&Config { near_rad: 0.0118, ..config }).is_ok());
        assert!(Params::new(&Config { near_rad: 0.0, ..config }).is_ok());
    }
}
