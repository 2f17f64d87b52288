//! The boundary curves (11) and (13), and the count of unstable roots by what a path in the K_P-K_D plane crosses.
//!
//! On the curve a pair of roots is at +-jw. Along a path of growing K_P the pair goes to the right where K_D of the
//! curve grows with w, and along a path of growing K_D where K_P of the curve falls with w: with
//! D(jw) = e^(-jwL) ((K_P - K_P(w)) + jw (K_D - K_D(w))) the derivative of the root is
//! dK_P / (w K_D'(w) - j K_P'(w)) in the first case and -w dK_D / (K_P'(w) + jw K_D'(w)) in the second. On the line
//! K_P = 0 a real root is at zero; below it the loop is never stable.

use super::case::{Fluid, Gains, Loop, Plant};
use super::zeros::{Scan, zeros};

/// The gains with which a pair of roots is at +-j`omega_rad_s`: (11) for a dead time, (13) for a lag, and either with
/// no delay of the fluid.
#[must_use]
pub fn boundary(plant: &Plant, omega_rad_s: f64) -> Gains {
    let Plant { inertia_kg_m2: j, torque_delay_s, q0_nm_s_rad: q0, q1_nm_s_rad: q1, fluid } = *plant;
    let w = omega_rad_s;
    let (sin, cos) = (w * torque_delay_s).sin_cos();
    match fluid {
        Fluid::None => dead_time_boundary(j, q0 + q1, (0.0, 0.0), w, (sin, cos)),
        Fluid::DeadTime { l_q_s } => {
            let (sin_q, cos_q) = (w * l_q_s).sin_cos();
            dead_time_boundary(j, q0, (q1 * sin_q, q1 * cos_q), w, (sin, cos))
        }
        Fluid::Lag { t_q_s } => {
            let tw2 = (t_q_s * w).powi(2);
            let m = j - q1 * t_q_s + j * tw2;
            let n = q1 + q0 + q0 * tw2;
            Gains {
                k_p_nm_rad: (w * w * m * cos + w * n * sin) / (1.0 + tw2),
                k_d_nm_s_rad: (w * m * sin - n * cos) / (1.0 + tw2),
            }
        }
    }
}

/// Equation (11), with Q1 sin(w L_Q) and Q1 cos(w L_Q) in `q1`.
fn dead_time_boundary(j: f64, q0: f64, q1: (f64, f64), w: f64, (sin, cos): (f64, f64)) -> Gains {
    Gains {
        k_p_nm_rad: (j * w * w - q1.0 * w) * cos + w * (q0 + q1.1) * sin,
        k_d_nm_s_rad: (j * w - q1.0) * sin - (q0 + q1.1) * cos,
    }
}

/// The scan that sees every crossing of the curve that a loop bounded by `to_rad_s` can have.
pub(super) fn scan(plant: &Plant, to_rad_s: f64) -> Scan {
    Scan::new(to_rad_s, plant.torque_delay_s + plant.fluid.delay_s())
}

/// Whether the gains are inside the stable region by the curves alone.
#[must_use]
pub fn is_inside(closed: &Loop) -> bool {
    closed.gains().k_p_nm_rad > 0.0 && unstable_roots(closed) == 0
}

/// Roots right of the imaginary axis, by what the path (0, 0) -> (0, K_D) -> (K_P, K_D) crosses.
#[must_use]
pub fn unstable_roots(closed: &Loop) -> usize {
    let Gains { k_p_nm_rad: k_p, k_d_nm_s_rad: k_d } = closed.gains();
    let plant = closed.plant();
    let viscosity = plant.q0_nm_s_rad + plant.q1_nm_s_rad;
    let scan = scan(plant, closed.frequency_bound_rad_s());
    let mut pairs = pairs_without_control(plant);

    // Along the axis, just right of it, where the free rotor's root at zero has gone left.
    for zero in zeros(|w| boundary(plant, w).k_p_nm_rad / (w * w), scan) {
        let at = boundary(plant, zero.omega_rad_s).k_d_nm_s_rad;
        pairs += passed(at, k_d) * if zero.rising { -1 } else { 1 };
    }
    // The curve starts on the axis, at K_D = -(Q0 + Q1); it is in the way if it leaves to the right.
    let starts_right = boundary(plant, scan.from_rad_s).k_p_nm_rad > 0.0;
    if starts_right && k_d < -viscosity {
        pairs += 1;
    }
    // From the axis to the point.
    for zero in zeros(|w| boundary(plant, w).k_d_nm_s_rad - k_d, scan) {
        let at = boundary(plant, zero.omega_rad_s).k_p_nm_rad;
        pairs += passed(at, k_p) * if zero.rising { 1 } else { -1 };
    }
    // Below the axis the root at zero, -K_P / (Q0 + Q1 + K_D), has come to the other side.
    let real = match (k_p < 0.0, k_d > -viscosity) {
        (false, _) => 0,
        (true, true) => 1,
        (true, false) => -1,
    };
    usize::try_from(2 * pairs + real).unwrap_or(0)
}

/// 1 if a path from just above 0 to `to` passes `at` upwards, -1 if downwards, 0 if not.
fn passed(at: f64, to: f64) -> i64 {
    i64::from(0.0 < at && at < to) - i64::from(to < at && at <= 0.0)
}

/// Pairs right of the axis of J s + Q(s), the rotor with its damper alone. Only a dead time can do it: roots pass
/// +-jw at w = sqrt(Q1^2 - Q0^2) / J, always to the right, once for each turn of w L_Q beyond acos(-Q0 / Q1).
fn pairs_without_control(plant: &Plant) -> i64 {
    let Fluid::DeadTime { l_q_s } = plant.fluid else { return 0 };
    let (q0, q1) = (plant.q0_nm_s_rad, plant.q1_nm_s_rad);
    if q1 <= q0 {
        return 0;
    }
    let w = ((q1 - q0) * (q1 + q0)).sqrt() / plant.inertia_kg_m2;
    let turns = (w * l_q_s - (-q0 / q1).acos()) / std::f64::consts::TAU;
    // Bounded by the phase a checked loop may have.
    #[allow(clippy::cast_possible_truncation)]
    let pairs = (turns.floor() + 1.0).max(0.0) as i64;
    pairs
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
    use super::*;
    use crate::stability::argument;
    use crate::stability::case::NormalisedGains;
    use crate::stability::testing::{closed, plant};
    use nalgebra::Complex;

    #[test]
    fn the_characteristic_function_is_zero_on_the_curves() {
        for fluid in [Fluid::None, Fluid::DeadTime { l_q_s: 0.007 }, Fluid::Lag { t_q_s: 0.007 }] {
            for w in [0.3, 40.0, 333.0, 2000.0] {
                let plant = Plant { fluid, ..plant(0.005, 0.2, 10.0) };
                let on = Loop::new(plant, boundary(&plant, w)).unwrap();
                let s = Complex::new(0.0, w);
                assert!(on.characteristic(s).norm() < 1e-12 * on.open_denominator(s).norm());
            }
        }
    }

    #[test]
    fn the_papers_point_is_inside_for_1_to_10_ms() {
        for ms in 1..=10 {
            for fluid in [Fluid::None, Fluid::DeadTime { l_q_s: 0.005 }, Fluid::Lag { t_q_s: 0.005 }] {
                assert!(is_inside(&closed(f64::from(ms) * 1e-3, 0.2, 10.0, fluid)), "{ms} ms {fluid:?}");
            }
        }
    }

    #[test]
    fn the_first_quadrant_is_a_convention() {
        // A negative K_D smaller than the viscosity is stable; one larger is not.
        let plant = Plant { fluid: Fluid::None, ..plant(0.005, 0.2, 10.0) };
        let with = |k_d| Loop::new(plant, Gains { k_p_nm_rad: 50.0, k_d_nm_s_rad: k_d }).unwrap();
        assert!(is_inside(&with(-5.0)));
        assert_eq!(unstable_roots(&with(-15.0)), 2);
    }

    #[test]
    fn all_four_quadrants_are_counted_as_the_argument_principle_counts() {
        for fluid in [Fluid::None, Fluid::DeadTime { l_q_s: 0.007 }, Fluid::Lag { t_q_s: 0.007 }] {
            let plant = Plant { fluid, ..plant(0.004, 0.3, 22.0) };
            for (i, k) in (-20..20).flat_map(|i| (-20..20).map(move |k| (i, k))) {
                let (kp, kd) = (0.21 * (f64::from(i) + 0.4), 0.23 * (f64::from(k) + 0.3));
                let gains = NormalisedGains { kp, kd }.physical(plant.inertia_kg_m2, plant.torque_delay_s);
                let closed = Loop::new(plant, gains).unwrap();
                assert_eq!(Some(unstable_roots(&closed)), argument::unstable_roots(&closed), "{closed:?}");
            }
        }
    }
}
