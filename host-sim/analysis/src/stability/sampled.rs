//! The loop as it runs: sampled and held, its delays whole control periods.
//!
//! At each tick the control reads the true angle and speed, and the torque u = -K_P x - K_D w is held for one period
//! from `round(L / period)` ticks later. A dead time of the fluid acts on the field, which the control computes from
//! the speed at the tick as well, so Q1 w is held for one period from `round(L_Q / period)` ticks later. Viscosity
//! without delay and a lag belong to the fluid, act all the time, and are solved exactly over a period.
//!
//! A hold delays by half a period on average. To first order this loop is therefore the continuous one of
//! [`held_equivalent`], not the one its delays name; what remains falls with the square of frequency times period.

use nalgebra::DMatrix;

use super::case::{Fluid, Loop, LoopError, Plant};
use super::spectrum::eigenvalues;

/// The control period, s (section 1 of the specification).
pub const PERIOD_S: f64 = 0.5e-3;

/// Control periods of the longest delay accepted; 0.3 s.
const MAX_TICKS: usize = 600;

/// Spectral radius of one control period of `period_s`; the loop is stable below 1.
///
/// # Errors
/// [`LoopError::TooStiff`] if the delays have too many ticks, [`LoopError::NoConvergence`] if
/// its eigenvalues cannot be found.
pub fn spectral_radius(closed: &Loop, period_s: f64) -> Result<f64, LoopError> {
    let matrix = transition(closed, period_s)?;
    Ok(eigenvalues(matrix)?.iter().map(|z| z.norm()).fold(0.0, f64::max))
}

/// The continuous loop with the delays of the sampled one: whole periods, and half a period for each hold.
///
/// # Errors
/// As [`Loop::new`].
pub fn held_equivalent(closed: &Loop, period_s: f64) -> Result<Loop, LoopError> {
    let held = |delay_s: f64| ((delay_s / period_s).round() + 0.5) * period_s;
    let plant = closed.plant();
    let fluid = match plant.fluid {
        Fluid::DeadTime { l_q_s } => Fluid::DeadTime { l_q_s: held(l_q_s) },
        Fluid::None | Fluid::Lag { .. } => plant.fluid,
    };
    Loop::new(Plant { torque_delay_s: held(plant.torque_delay_s), fluid, ..*plant }, closed.gains())
}

/// Whole periods of a delay.
fn ticks(delay_s: f64, period_s: f64) -> Result<usize, LoopError> {
    let ticks = (delay_s / period_s).round();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
    if ticks < MAX_TICKS as f64 {
        Ok(ticks as usize)
    } else {
        Err(LoopError::TooStiff(format!("a delay of {ticks} control periods, {MAX_TICKS} allowed")))
    }
}

/// One period as a matrix. The state is angle, speed, lagged speed, then the torques u still on their way, the next to
/// act last, then the speeds the fluid has yet to see, in the same order.
fn transition(closed: &Loop, period_s: f64) -> Result<DMatrix<f64>, LoopError> {
    let (plant, gains) = (closed.plant(), closed.gains());
    let torque_ticks = ticks(plant.torque_delay_s, period_s)?;
    let fluid_ticks = match plant.fluid {
        Fluid::DeadTime { l_q_s } => Some(ticks(l_q_s, period_s)?),
        Fluid::None | Fluid::Lag { .. } => None,
    };
    let size = 3 + torque_ticks + fluid_ticks.unwrap_or(0);
    // Rows that read the torque computed at this tick, and the speed measured at it, out of the state.
    let mut torque = DMatrix::zeros(1, size);
    torque[(0, 0)] = -gains.k_p_nm_rad;
    torque[(0, 1)] = -gains.k_d_nm_s_rad;
    let mut speed = DMatrix::zeros(1, size);
    speed[(0, 1)] = 1.0;

    let mut matrix = DMatrix::zeros(size, size);
    let acting = delay_line(&mut matrix, 3, torque_ticks, torque);
    let held = rotor_over_a_period(plant, period_s);
    matrix.view_mut((0, 0), (3, 3)).copy_from(&held.view((0, 0), (3, 3)));
    let mut rotor = held.view((0, 3), (3, 1)) * acting;
    if let Some(fluid_ticks) = fluid_ticks {
        let seen = delay_line(&mut matrix, 3 + torque_ticks, fluid_ticks, speed);
        rotor -= held.view((0, 3), (3, 1)) * seen * plant.q1_nm_s_rad;
    }
    let mut rows = matrix.view_mut((0, 0), (3, size));
    rows += rotor;
    Ok(matrix)
}

/// Shifts `entering` through `length` rows from `first` on, and returns the row that reads what leaves.
fn delay_line(matrix: &mut DMatrix<f64>, first: usize, length: usize, entering: DMatrix<f64>) -> DMatrix<f64> {
    if length == 0 {
        return entering;
    }
    matrix.row_mut(first).copy_from(&entering.row(0));
    for row in first + 1..first + length {
        matrix[(row, row - 1)] = 1.0;
    }
    let mut leaving = DMatrix::zeros(1, entering.ncols());
    leaving[(0, first + length - 1)] = 1.0;
    leaving
}

/// Angle, speed and lagged speed after a period, from those and a held torque (fourth column): a matrix exponential.
fn rotor_over_a_period(plant: &Plant, period_s: f64) -> DMatrix<f64> {
    let per_inertia = 1.0 / plant.inertia_kg_m2;
    let mut rate = DMatrix::zeros(4, 4);
    rate[(0, 1)] = 1.0;
    rate[(1, 1)] = -plant.q0_nm_s_rad * per_inertia;
    rate[(1, 3)] = per_inertia;
    match plant.fluid {
        Fluid::Lag { t_q_s } if t_q_s > 0.0 => {
            rate[(1, 2)] = -plant.q1_nm_s_rad * per_inertia;
            rate[(2, 1)] = 1.0 / t_q_s;
            rate[(2, 2)] = -1.0 / t_q_s;
        }
        Fluid::None | Fluid::Lag { .. } => rate[(1, 1)] -= plant.q1_nm_s_rad * per_inertia,
        Fluid::DeadTime { .. } => {}
    }
    // A speed behind no lag is an idle state; it must not keep its value.
    if rate[(2, 2)] == 0.0 {
        rate[(2, 2)] = -1.0 / period_s;
    }
    (rate * period_s).exp()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
    use super::*;
    use crate::stability::testing::closed;
    use nalgebra::DVector;

    /// The same loop in small steps with buffers, as a simulation would.
    fn growth_per_period(closed: &Loop) -> f64 {
        const STEPS: usize = 400;
        let (plant, gains) = (*closed.plant(), closed.gains());
        let ticks = |s: f64| (s / PERIOD_S).round() as usize;
        let (d, m) = (ticks(plant.torque_delay_s), ticks(plant.fluid.delay_s()));
        let (mut x, mut v, mut z) = (1e-3, 0.0, 0.0);
        let (mut torques, mut speeds) = (vec![], vec![]);
        let dt = PERIOD_S / STEPS as f64;
        let mut sizes = vec![];
        for k in 0..1200 {
            torques.push(-gains.k_p_nm_rad * x - gains.k_d_nm_s_rad * v);
            speeds.push(v);
            let u = if k >= d { torques[k - d] } else { 0.0 };
            let w = if k >= m { speeds[k - m] } else { 0.0 };
            for _ in 0..STEPS {
                let drag = match plant.fluid {
                    Fluid::None => v,
                    Fluid::DeadTime { .. } => w,
                    Fluid::Lag { t_q_s } => {
                        z += dt * (v - z) / t_q_s;
                        z
                    }
                };
                v += dt * (u - plant.q0_nm_s_rad * v - plant.q1_nm_s_rad * drag) / plant.inertia_kg_m2;
                x += dt * v;
            }
            sizes.push(x.abs() + v.abs() * 0.005);
        }
        let largest = |range: std::ops::Range<usize>| sizes[range].iter().fold(0.0, |a: f64, &b| a.max(b));
        (largest(1000..1200) / largest(400..600)).powf(1.0 / 600.0)
    }

    #[test]
    fn the_matrix_decays_as_a_step_by_step_run_does() {
        for fluid in [Fluid::None, Fluid::DeadTime { l_q_s: 0.003 }, Fluid::Lag { t_q_s: 0.003 }] {
            let closed = closed(0.005, 0.2, 10.0, fluid);
            let radius = spectral_radius(&closed, PERIOD_S).unwrap();
            let run = growth_per_period(&closed);
            assert!((radius - run).abs() < 5e-4, "{fluid:?}: {radius} by the matrix, {run} by the run");
        }
    }

    #[test]
    fn an_idle_lag_state_leaves_the_radius_alone() {
        let closed = closed(0.005, 0.2, 0.0, Fluid::None);
        let matrix = transition(&closed, PERIOD_S).unwrap();
        let idle = DVector::from_fn(matrix.nrows(), |k, _| if k == 2 { 1.0 } else { 0.0 });
        assert!((matrix * idle).norm() < 1.0);
        assert!(spectral_radius(&closed, PERIOD_S).unwrap() < 1.0);
    }
}
