//! Roots right of the imaginary axis by the argument principle.
//!
//! The characteristic function D has no pole there (a lag's pole is on the left), so the turns of D along the edge of
//! the right half of a disc that holds every such root ([`Loop::frequency_bound_rad_s`]) are their number. Half the
//! edge is enough, D being real on the real axis. On the arc D / (J s^2) stays within 1 of 1, so only its end counts;
//! down the imaginary axis each step is kept so short, by a bound on |D'|, that D cannot turn by more than 30 degrees
//! and cannot pass zero unseen.

use nalgebra::Complex;
use std::f64::consts::PI;

use super::case::{Fluid, Loop};

/// Share of |D| that one step may change; asin of it is the largest turn of a step.
const LARGEST_CHANGE: f64 = 0.5;
/// A step shorter than this share of the bound means a root on the axis, as far as double precision can tell.
const SHORTEST_STEP: f64 = 1e-15;
/// Radius of the disc over the bound on the roots: the arc keeps clear of a root that reaches the bound.
const CLEARANCE: f64 = 1.1;

/// Number of roots with a real part above 0, or none if one lies on the axis.
#[must_use]
pub fn unstable_roots(closed: &Loop) -> Option<usize> {
    let radius = CLEARANCE * closed.frequency_bound_rad_s();
    let at = |w: f64| closed.characteristic(Complex::new(0.0, w));
    let mut here = at(radius);
    let over_s2 = here / (-closed.plant().inertia_kg_m2 * radius * radius);
    let mut turned = PI + over_s2.arg();
    let mut w = radius;
    while w > 0.0 {
        let step = LARGEST_CHANGE * here.norm() / slope_bound(closed, w);
        if step < SHORTEST_STEP * radius {
            return None;
        }
        w = (w - step).max(0.0);
        let next = at(w);
        turned += (next / here).arg();
        here = next;
    }
    let count = (turned / PI).round();
    // A count of roots in a disc whose phase is bounded; it is not negative.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let count = count as usize;
    (here.norm() > 0.0).then_some(count)
}

/// |dD/ds| on the imaginary axis is at most this from 0 up to j`w`.
fn slope_bound(closed: &Loop, w: f64) -> f64 {
    let (plant, gains) = (closed.plant(), closed.gains());
    let fluid = match plant.fluid {
        Fluid::None | Fluid::Lag { .. } => 1.0,
        Fluid::DeadTime { l_q_s } => 1.0 + w * l_q_s,
    };
    2.0 * plant.inertia_kg_m2 * w
        + plant.q0_nm_s_rad
        + plant.q1_nm_s_rad * fluid
        + gains.k_d_nm_s_rad.abs() * (1.0 + w * plant.torque_delay_s)
        + gains.k_p_nm_rad.abs() * plant.torque_delay_s
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
    use super::*;
    use crate::stability::case::Gains;
    use crate::stability::testing::plant;

    #[test]
    fn counts_the_roots_of_loops_solved_by_hand() {
        // Almost no delay: J s^2 + (Q + K_D) s + K_P, whose roots are those of the quadratic.
        let quadratic = |k_p, k_d| {
            let plant = plant(1e-7, 1.0, 0.0);
            unstable_roots(&Loop::new(plant, Gains { k_p_nm_rad: k_p, k_d_nm_s_rad: k_d }).unwrap())
        };
        assert_eq!(quadratic(10.0, 0.5), Some(0));
        assert_eq!(quadratic(10.0, -2.0), Some(2));
        assert_eq!(quadratic(-10.0, 0.5), Some(1));
        assert_eq!(quadratic(0.0, 0.5), None);
    }

    #[test]
    fn a_root_placed_on_the_axis_is_not_counted_either_way() {
        let plant = plant(0.005, 0.2, 10.0);
        let on = Loop::new(plant, crate::stability::curves::boundary(&plant, 300.0)).unwrap();
        assert_eq!(unstable_roots(&on), None);
    }
}
