//! u = K_P e - K_D w (control.md section 4).

use crate::maths::{self, Bounded};
use crate::units::Counts;
use crate::{Faults, Limits, Params, TORQUE_CEILING_NM};

/// Reference minus position, counts, exact; held at the ends of the range with a limit code where it does not fit.
pub(crate) fn error_counts(reference: Counts, position: Counts) -> (i32, Limits) {
    match reference.0.checked_sub(position.0) {
        Some(error) => (error, Limits::empty()),
        None => (reference.0.saturating_sub(position.0), Limits::ERROR_RANGE),
    }
}

/// The torque command, N m within plus and minus the limit and a bound, with what bounded it.
pub(crate) fn torque_nm(params: &Params, error_counts: i32, speed_rad_s: f32, bound_nm: f32) -> (f32, Limits, Faults) {
    let wanted = params.kp_nm_count * error_counts as f32 - params.kd_nm_s_rad * speed_rad_s;
    // The ceiling is a constant of the code: no damaged parameter can raise it.
    let (ceiling, _) = maths::limit(params.torque_limit_nm, 0.0, TORQUE_CEILING_NM);
    let (ceiling, _) = maths::limit(bound_nm, 0.0, ceiling);
    match maths::limit(wanted, -ceiling, ceiling) {
        (torque, Bounded::Inside) => (torque, Limits::empty(), Faults::empty()),
        (torque, Bounded::Above) => (torque, Limits::TORQUE_ABOVE, Faults::empty()),
        (torque, Bounded::Below) => (torque, Limits::TORQUE_BELOW, Faults::empty()),
        (torque, Bounded::NotFinite) => (torque, Limits::empty(), Faults::NOT_FINITE),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::Config;

    #[test]
    fn a_radian_and_a_radian_a_second_give_the_gains() {
        let params = Params::new(&Config::default()).unwrap();
        let (torque, limits, _) = torque_nm(&params, Counts::from_rad(0.1).0, 0.0, 30.0);
        assert!((torque - 24.0).abs() < 2e-3 && limits.is_empty(), "{torque}");
        assert!((torque_nm(&params, 0, 1.0, 30.0).0 + 6.96).abs() < 1e-6);
    }

    #[test]
    fn limits_are_coded_and_the_error_saturates() {
        let params = Params::new(&Config::default()).unwrap();
        assert_eq!(torque_nm(&params, i32::MAX, 0.0, f32::MAX).0, 30.0);
        assert_eq!(torque_nm(&params, i32::MAX, 0.0, 2.0), (2.0, Limits::TORQUE_ABOVE, Faults::empty()));
        assert_eq!(torque_nm(&params, i32::MIN, 0.0, 30.0).1, Limits::TORQUE_BELOW);
        assert_eq!(torque_nm(&params, 0, f32::NAN, 30.0), (0.0, Limits::empty(), Faults::NOT_FINITE));
        assert_eq!(error_counts(Counts(i32::MAX), Counts(-1)), (i32::MAX, Limits::ERROR_RANGE));
    }
}
