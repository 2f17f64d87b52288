//! The rightmost roots, from a Chebyshev discretisation of the loop as a delay equation, polished by Newton's method.
//!
//! The state is the angle now, the speed over the longest delay, and the speed behind the lag. The angle a delay ago is
//! the angle now less the integral of the speed, so the angle needs no history. On Chebyshev points the generator of
//! the semigroup becomes a matrix: its first row is the equation of motion, the others differentiate (Breda, Maset,
//! Vermiglio, SIAM J. Sci. Comput. 27 (2005) 482). Its eigenvalues near the origin approach the roots faster than any
//! power of the number of points.

use nalgebra::{Complex, DMatrix, DVector};

use super::case::{Fluid, Loop, LoopError};
use super::chebyshev::Chebyshev;

/// Roots looked for beyond those right of the axis.
const ROOTS: usize = 8;
/// Largest degree tried; the matrix has two or three rows more than its points.
const MAX_DEGREE: usize = 400;
/// Newton's steps before an eigenvalue counts as none of a root.
const NEWTON_STEPS: usize = 30;

/// The rightmost roots of the closed loop, rad/s, from the right; of a pair, both. At least one.
///
/// # Errors
/// [`LoopError::NoConvergence`] if the eigenvalues cannot be found, [`LoopError::Unresolved`] for a multiple root or
/// delays so long for the loop that the points allowed do not resolve its roots.
pub fn rightmost_roots(closed: &Loop) -> Result<Vec<Complex<f64>>, LoopError> {
    let span_s = history_s(closed);
    // An exponential that turns r rad over the span needs a degree above r / 2, then converges; a root that far out
    // takes more than the bound, which few do, so the first try is short of it and the check below decides.
    let reach = 0.5 * closed.frequency_bound_rad_s() * span_s;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let mut degree = (14.0 + 1.2 * reach) as usize;
    while degree <= MAX_DEGREE {
        if let Some(roots) = roots_at_degree(closed, span_s, degree)? {
            return Ok(roots);
        }
        degree = degree * 3 / 2;
    }
    Err(LoopError::Unresolved { points: MAX_DEGREE })
}

/// Roots with a real part above 0 among [`rightmost_roots`].
#[must_use]
pub fn unstable_roots(roots: &[Complex<f64>]) -> usize {
    roots.iter().filter(|s| s.re > 0.0).count()
}

/// The longest delay, s.
fn history_s(closed: &Loop) -> f64 {
    let plant = closed.plant();
    match plant.fluid {
        Fluid::DeadTime { l_q_s } => l_q_s.max(plant.torque_delay_s),
        Fluid::None | Fluid::Lag { .. } => plant.torque_delay_s,
    }
}

/// The polished roots, or none if some eigenvalue among the rightmost is not close to one.
fn roots_at_degree(closed: &Loop, span_s: f64, degree: usize) -> Result<Option<Vec<Complex<f64>>>, LoopError> {
    let matrix = generator(closed, span_s, degree);
    let mut eigenvalues: Vec<_> = eigenvalues(matrix)?.iter().map(|p| p / span_s).collect();
    eigenvalues.sort_by(|a, b| b.re.total_cmp(&a.re));
    let wanted = eigenvalues.iter().filter(|s| s.re > 0.0).count() + ROOTS;
    let mut roots: Vec<Complex<f64>> = Vec::with_capacity(wanted);
    for (rank, &start) in eigenvalues.iter().take(wanted).enumerate() {
        let scale = start.norm() + 1.0 / span_s;
        match newton(closed, start) {
            Some(root) if (root - start).norm() < 0.02 * scale => {
                if roots.iter().all(|s| (s - root).norm() > 1e-7 * scale) {
                    roots.push(root);
                }
            }
            // The first and any that may be unstable must be a root's; further left the discretisation runs out.
            _ if rank == 0 || start.re > -0.1 / span_s => return Ok(None),
            _ => break,
        }
    }
    roots.sort_by(|a, b| b.re.total_cmp(&a.re));
    Ok(Some(roots))
}

/// Eigenvalues of a balanced real matrix.
pub(super) fn eigenvalues(mut matrix: DMatrix<f64>) -> Result<DVector<Complex<f64>>, LoopError> {
    let size = matrix.nrows();
    nalgebra::linalg::balancing::balance_parlett_reinsch(&mut matrix);
    let schur = nalgebra::Schur::try_new(matrix, f64::EPSILON, 200 * size);
    schur.map(|schur| schur.complex_eigenvalues()).ok_or(LoopError::NoConvergence { size })
}

/// The generator in units of the span: rows speed at the points from now to the longest delay ago, angle (over the
/// span), speed behind the lag.
fn generator(closed: &Loop, span_s: f64, degree: usize) -> DMatrix<f64> {
    let (plant, gains) = (closed.plant(), closed.gains());
    let chebyshev = Chebyshev::new(degree);
    let points = degree + 1;
    let (angle, lagged) = (points, points + 1);
    let lag_s = match plant.fluid {
        Fluid::Lag { t_q_s } if t_q_s > 0.0 => Some(t_q_s),
        _ => None,
    };
    let size = points + 1 + usize::from(lag_s.is_some());
    let mut matrix = DMatrix::zeros(size, size);
    matrix.view_mut((1, 0), (degree, points)).copy_from(&chebyshev.derivative().rows(1, degree));

    let back = plant.torque_delay_s / span_s;
    let per_inertia = span_s / plant.inertia_kg_m2;
    let (speed_back, travel_back) = (chebyshev.value_at(-back), chebyshev.integral_from(-back));
    for column in 0..points {
        matrix[(0, column)] =
            per_inertia * (gains.k_p_nm_rad * span_s * travel_back[column] - gains.k_d_nm_s_rad * speed_back[column]);
    }
    matrix[(0, 0)] -= per_inertia * plant.q0_nm_s_rad;
    matrix[(0, angle)] = -per_inertia * gains.k_p_nm_rad * span_s;
    matrix[(angle, 0)] = 1.0;
    let damping = per_inertia * plant.q1_nm_s_rad;
    match (plant.fluid, lag_s) {
        (_, Some(t_q_s)) => {
            matrix[(0, lagged)] = -damping;
            matrix[(lagged, 0)] = span_s / t_q_s;
            matrix[(lagged, lagged)] = -span_s / t_q_s;
        }
        (Fluid::DeadTime { l_q_s }, None) => {
            let speed = chebyshev.value_at(-l_q_s / span_s);
            for column in 0..points {
                matrix[(0, column)] -= damping * speed[column];
            }
        }
        (Fluid::None | Fluid::Lag { .. }, None) => matrix[(0, 0)] -= damping,
    }
    matrix
}

/// Newton's method on the characteristic function from `start`, rad/s.
fn newton(closed: &Loop, start: Complex<f64>) -> Option<Complex<f64>> {
    let mut s = start;
    for _ in 0..NEWTON_STEPS {
        let step = closed.characteristic(s) / closed.characteristic_slope(s);
        s -= step;
        if !(s.re.is_finite() && s.im.is_finite()) {
            return None;
        }
        if step.norm() <= 1e-13 * s.norm() {
            return Some(s);
        }
    }
    // Rounding may keep the last bits moving; a root it is if the step is small.
    let step = closed.characteristic(s) / closed.characteristic_slope(s);
    (step.norm() <= 1e-9 * s.norm()).then_some(s)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
    use super::*;
    use crate::stability::case::Gains;
    use crate::stability::testing::{closed, plant};

    #[test]
    fn a_quadratic_has_its_two_roots() {
        let plant = plant(1e-7, 1.0, 0.0);
        let pair = Loop::new(plant, Gains { k_p_nm_rad: 10.0, k_d_nm_s_rad: 0.5 }).unwrap();
        let roots = rightmost_roots(&pair).unwrap();
        let exact = Complex::new(-10.0, (10.0_f64 / 0.075 - 100.0).sqrt());
        assert!((roots[0].re - exact.re).abs() < 1e-4 && (roots[0].im.abs() - exact.im).abs() < 1e-4, "{roots:?}");
    }

    #[test]
    fn the_dominant_root_of_the_papers_point_without_viscosity_is_real() {
        // The point is next to that of a triple real root, (0.079, 0.461): one root stays real, the next two are a pair
        // damped so well (0.97) that it does not show. The specification calls all three real.
        let roots = rightmost_roots(&closed(0.005, 0.0, 0.0, Fluid::None)).unwrap();
        assert!(roots[0].im == 0.0 && (roots[0].re / -93.77 - 1.0).abs() < 1e-4, "{roots:?}");
        assert!(-roots[1].re / roots[1].norm() > 0.97, "{roots:?}");
    }
}
