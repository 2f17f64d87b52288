//! What is wrong with an experiment, by the flag that asked for it and in its unit.

use er_servo::experiment::ExperimentError;

use crate::Error;

/// A value an experiment cannot take. `flags` are those of other names than the value has, each with the name of the value.
pub(super) fn refused(error: &ExperimentError, flags: &[(&str, &str)]) -> Error {
    let own = error.name.strip_suffix("_rad").map_or(error.name.to_owned(), |angle| format!("{angle}_deg"));
    let own = own.replace('_', "-");
    let flag = flags.iter().find(|(name, _)| *name == error.name).map_or(own.as_str(), |(_, flag)| flag);
    let (value, min, max) = if error.name.ends_with("_rad") {
        let [value, min, max] = [error.value, error.min, error.max].map(|rad| f64::from(rad).to_degrees());
        // The bounds are those of radians: of their degrees, three digits within.
        (rounded(value, 6, f64::round), rounded(min, 3, f64::ceil), rounded(max, 3, f64::floor))
    } else {
        let [value, min, max] = [error.value, error.min, error.max].map(|value| value.to_string());
        (value, min, max)
    };
    Error::Usage(format!("--{flag}: {value} is not allowed, {min} to {max} is"))
}

/// A number of so many digits.
fn rounded(value: f64, digits: i32, round: fn(f64) -> f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals = digits - 1 - value.abs().log10().floor() as i32;
    let scale = 10_f64.powi(decimals.abs());
    let rounded = if decimals > 0 { round(value * scale) / scale } else { round(value / scale) * scale };
    rounded.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(name: &'static str, value: f32, min: f32, max: f32) -> String {
        refused(&ExperimentError { name, value, min, max }, &[("from_hz", "low-hz")]).to_string()
    }

    #[test]
    fn a_value_is_told_as_it_was_given_with_bounds_that_are_allowed() {
        let amplitude = message("amplitude_rad", 4000_f32.to_radians(), -6.3, 6.3);
        assert_eq!(amplitude, "--amplitude-deg: 4000 is not allowed, -360 to 360 is");
        let travel = message("travel_rad", 1e6_f32.to_radians(), 1e-4, 600.0);
        assert_eq!(travel, "--travel-deg: 1000000 is not allowed, 0.00573 to 34300 is");
        assert_eq!(message("speed_rad_s", 0.0, 1e-4, 50.0), "--speed-rad-s: 0 is not allowed, 0.0001 to 50 is");
        assert_eq!(message("from_hz", 200.0, 0.0, 100.0), "--low-hz: 200 is not allowed, 0 to 100 is");
        assert!(message("amplitude_rad", f32::NAN, -6.3, 6.3).starts_with("--amplitude-deg: NaN is not allowed"));
    }
}
