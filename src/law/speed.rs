//! Speed from counts: backward difference and a first-order low-pass (control.md section 3).

use crate::{Faults, Params};

/// Below this the tail of the low-pass is rounding, and would end in subnormal numbers, rad/s.
const REST_RAD_S: f32 = 1e-6;

/// The next speed estimate, rad/s, from the last one and the way of this tick, counts.
pub(crate) fn estimate_rad_s(params: &Params, last_rad_s: f32, moved_counts: i32) -> f32 {
    let raw = params.rad_s_per_count * moved_counts as f32;
    let next = last_rad_s + params.speed_filter_gain * (raw - last_rad_s);
    if moved_counts == 0 && next.abs() < REST_RAD_S { 0.0 } else { next }
}

/// The speed the law uses, rad/s: the estimate, or the converter's where the parameters say so. Never NaN or infinite.
pub(crate) fn select(params: &Params, estimate_rad_s: f32, converter_rad_s: f32) -> (f32, Faults) {
    let speed = if params.speed_from_converter { converter_rad_s } else { estimate_rad_s };
    if speed.is_finite() { (speed, Faults::empty()) } else { (0.0, Faults::NOT_FINITE) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::Config;

    #[test]
    fn one_count_a_sample_is_25_7_mrad_s_and_the_filter_takes_a_millisecond() {
        let params = Params::new(&Config::default()).unwrap();
        assert!((params.rad_s_per_count - 0.025_566).abs() < 1e-5);
        let mut speed = 0.0;
        for _ in 0..2 {
            speed = estimate_rad_s(&params, speed, 100);
        }
        let settled = 100.0 * params.rad_s_per_count;
        assert!((speed / settled - (1.0 - (-1.0_f32).exp())).abs() < 1e-5);
    }

    #[test]
    fn without_a_filter_it_is_the_difference_and_rest_is_exactly_zero() {
        let params = Params::new(&Config { speed_filter_s: 0.0, ..Config::default() }).unwrap();
        let speed = estimate_rad_s(&params, 3.0, -7);
        assert!((speed + 7.0 * params.rad_s_per_count).abs() < 5e-7, "{speed}");
        let params = Params::new(&Config::default()).unwrap();
        let speed = (0..60).fold(1.0, |speed, _| estimate_rad_s(&params, speed, 0));
        assert_eq!(speed, 0.0);
    }

    #[test]
    fn a_converter_speed_that_is_no_number_is_a_fault() {
        let params = Params::new(&Config { speed_from_converter: true, ..Config::default() }).unwrap();
        assert_eq!(select(&params, 1.0, 2.0), (2.0, Faults::empty()));
        assert_eq!(select(&params, 1.0, f32::NAN), (0.0, Faults::NOT_FINITE));
    }
}
