//! The noise of each equation: what neighbouring bumps do not share.

use super::problem::Problem;

/// Model form is never exact: a share of the torque that no answer is built on.
const FORM_SHARE: f64 = 1.5e-3;
/// Variance of a row minus the mean of its neighbours over that of a row, for white torque and half-width/2 spacing.
const SHARED: f64 = 0.8;

/// A block is far out where its residual is this many times the median block's,
const FAR_OUT: f64 = 4.0;
/// and such blocks are no more than this share of all: more of them are what the machine does.
const FEW: f64 = 0.05;

/// One over the noise of each equation. In recordings that are only predicted, a few blocks far beyond all others (a crash,
/// a rewind before the run) would hold most of the squares and decide alone; their weights are lowered until they count as
/// the limit. In recordings to fit they are what is to be explained.
pub(crate) fn weights(problem: &Problem, residual: &[f64]) -> Vec<f64> {
    let mut weights: Vec<f64> = deviations(problem, residual).iter().map(|deviation| 1.0 / deviation).collect();
    let mut sums = vec![(0.0, 0.0); problem.blocks];
    for ((equation, residual), weight) in problem.equations.iter().zip(residual).zip(&weights) {
        let sum = &mut sums[equation.block];
        *sum = (sum.0 + (residual * weight).powi(2), sum.1 + 1.0);
    }
    let size = |(squares, count): (f64, f64)| (squares / count).sqrt();
    let mut sizes: Vec<f64> = sums.iter().filter(|sum| sum.1 > 0.0).map(|&sum| size(sum)).collect();
    sizes.sort_by(f64::total_cmp);
    let limit = FAR_OUT * sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    let beyond = sizes.iter().filter(|size| **size > limit).count();
    if beyond as f64 <= FEW * sizes.len() as f64 {
        for (equation, weight) in problem.equations.iter().zip(&mut weights).skip(problem.fitted_equations()) {
            *weight *= (limit / size(sums[equation.block]).max(1e-300)).min(1.0);
        }
    }
    weights
}

/// Standard deviation of each equation, N m (N): position noise through the inertia, torque noise from what a row does
/// not share with its neighbours of the same width (a median, so that events do not count), and the share of form.
fn deviations(problem: &Problem, residual: &[f64]) -> Vec<f64> {
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
            let position = problem.nominal.inertia * equation.acceleration_noise;
            let measured = local[equation.recording * widths + equation.width];
            (position.max(measured).powi(2) + (FORM_SHARE * rms).powi(2)).sqrt().max(1e-12)
        })
        .collect()
}

fn local_deviation(series: &[(f64, f64)]) -> f64 {
    let mut changes: Vec<f64> = series
        .windows(3)
        .filter(|three| {
            let (before_s, after_s) = (three[1].0 - three[0].0, three[2].0 - three[1].0);
            after_s.max(before_s) < 1.5 * after_s.min(before_s)
        })
        .map(|three| (three[1].1 - 0.5 * (three[0].1 + three[2].1)).abs())
        .collect();
    if changes.len() < 8 {
        return 0.0;
    }
    changes.sort_by(f64::total_cmp);
    1.4826 * changes[changes.len() / 2] / SHARED.sqrt()
}
