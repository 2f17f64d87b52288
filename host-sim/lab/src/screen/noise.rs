//! The noise of each equation: what neighbouring bumps do not share.

use super::problem::Problem;

/// Model form is never exact: a share of the torque that no answer is built on.
const FORM_SHARE: f64 = 1.5e-3;
/// Variance of a row minus the mean of its neighbours over that of a row, for white torque and half-width/2 spacing.
const SHARED: f64 = 0.8;

/// Standard deviation of each equation, N m (N): position noise through the inertia, torque noise from what a row does
/// not share with its neighbours of the same width (a median, so that events do not count), and the share of form.
pub(crate) fn deviations(problem: &Problem, residual: &[f64], inertia: f64) -> Vec<f64> {
    let recordings = problem.motions.len();
    let widths = problem.equations.iter().map(|equation| equation.width + 1).max().unwrap_or(0);
    let mut series: Vec<Vec<(f64, f64)>> = vec![Vec::new(); recordings * widths];
    for (equation, &residual) in problem.equations.iter().zip(residual) {
        series[equation.recording * widths + equation.width].push((equation.row.centre_s, residual));
    }
    let local: Vec<f64> = series.iter().map(|series| local_deviation(series)).collect();
    problem
        .equations
        .iter()
        .map(|equation| {
            let effort = &problem.motions[equation.recording].effort;
            let rms = (effort.iter().map(|u| u * u).sum::<f64>() / effort.len() as f64).sqrt();
            let position = inertia * equation.acceleration_noise;
            let measured = local[equation.recording * widths + equation.width];
            (position.max(measured).powi(2) + (FORM_SHARE * rms).powi(2)).sqrt().max(1e-12)
        })
        .collect()
}

fn local_deviation(series: &[(f64, f64)]) -> f64 {
    let mut changes: Vec<f64> = series
        .windows(3)
        .filter(|three| (three[2].0 - three[1].0) < 1.5 * (three[1].0 - three[0].0))
        .map(|three| (three[1].1 - 0.5 * (three[0].1 + three[2].1)).abs())
        .collect();
    if changes.len() < 8 {
        return 0.0;
    }
    changes.sort_by(f64::total_cmp);
    1.4826 * changes[changes.len() / 2] / SHARED.sqrt()
}
