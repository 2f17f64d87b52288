//! Whether an effect is there: held-out gain, F-test under coloured residuals, and certainty over blocks.

use nalgebra::DVector;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::fit::Fit;
use super::problem::Problem;
use crate::effects::Effect;

/// Least gain in held-out error for an effect to be accepted.
pub const MIN_GAIN: f64 = 0.03;
/// Largest p-value, after correction for every variant tried.
pub const MAX_P: f64 = 1e-3;
/// Least t of the improvement over blocks: what a few neighbouring residuals share is no evidence.
pub(crate) const MIN_T: f64 = 3.0;

/// t from which a fit is worse than another: of three ways to take it the largest, so that 2.5 is passed by one in a
/// hundred fits that are as good.
pub(crate) const WORSE_T: f64 = 2.5;

/// An effect tried on top of others.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Which.
    pub effect: &'static Effect,
    /// All effects together at their optimum; the tried one is the last.
    pub fit: Fit,
    /// Relative fall of the held-out root mean square.
    pub gain: f64,
    /// Of the improvement, corrected for every variant tried.
    pub p_value: f64,
    /// t of the held-out improvement, paired over blocks; infinite for an event, which is in one block only.
    pub t: f64,
}

impl Trial {
    /// Whether it passes all tests.
    pub fn accepted(&self) -> bool {
        self.gain >= MIN_GAIN && self.p_value < MAX_P && self.t >= MIN_T && !self.at_bound()
    }

    /// Whether a value of the effect stands where the search ends.
    pub fn at_bound(&self) -> bool {
        self.fit.at_bound()
    }
}

/// Whether `fit` predicts the blocks significantly worse than `best`: paired over blocks, in squares or in shares of each
/// block's own, and by more than a hair.
pub fn worse(fit: &Fit, best: &Fit) -> bool {
    fall_t(&fit.heldout, &best.heldout) > WORSE_T && fit.heldout_sse() - best.heldout_sse() > 0.01 * best.heldout_sse()
}

/// t of the fall of the held-out squares of the blocks from one fit to another, over all blocks or, in shares of each block's
/// own, over those that are touched at all: an effect that shows in a few strong blocks, as one of standstill does, is as
/// certain as one that shows a little in all.
pub(crate) fn fall_t(from: &[f64], to: &[f64]) -> f64 {
    let touched: Vec<f64> = shares(from, to).filter(|change| change.abs() > TOUCHED).collect();
    let all = paired_t(from, to);
    if touched.len() < FEW { all } else { all.max(t_of_mean(&touched)) }
}

/// t of the fall over all blocks, in squares or in shares of each block's own, whichever is larger.
pub(crate) fn paired_t(from: &[f64], to: &[f64]) -> f64 {
    let pairs = from.iter().zip(to).filter(|(a, b)| **a > 0.0 || **b > 0.0);
    let changes: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
    t_of_mean(&changes).max(t_of_mean(&shares(from, to).collect::<Vec<f64>>()))
}

/// Fall of each block relative to its size.
fn shares(from: &[f64], to: &[f64]) -> impl Iterator<Item = f64> {
    from.iter().zip(to).filter(|(a, b)| *a + *b > 0.0).map(|(a, b)| (a - b) / (a + b))
}

/// t of the mean of changes.
pub(crate) fn t_of_mean(changes: &[f64]) -> f64 {
    let count = changes.len() as f64;
    if count < 2.0 {
        return 0.0;
    }
    let mean = changes.iter().sum::<f64>() / count;
    let variance = changes.iter().map(|c| (c - mean) * (c - mean)).sum::<f64>() / (count - 1.0);
    mean / (variance / count).sqrt().max(1e-300)
}

/// A block of which less of its squares changes says nothing about an effect that shows elsewhere.
const TOUCHED: f64 = 0.1;
/// So many blocks must be touched for their own mean to count.
const FEW: usize = 4;

/// F-test of an improvement, its freedom reduced by the correlation of neighbouring residuals (Newey-West, Bartlett).
pub(super) fn p_value(problem: &Problem, base: &Fit, fit: &Fit) -> f64 {
    let added = fit.freedom().saturating_sub(base.freedom()).max(1);
    f_test(problem, base.sse, &fit.residual, (added, fit.freedom()))
}

/// The same for a residual, of which `base` was the sum of squares before values were `added` to those now free.
pub(crate) fn f_test(problem: &Problem, base: f64, residual: &DVector<f64>, (added, free): (usize, usize)) -> f64 {
    let equations = problem.fitted_equations();
    let left = residual.rows(0, equations).norm_squared();
    let inflation = inflation(problem, residual);
    let (added, count) = (added as f64, (equations as f64 / inflation - free as f64).max(1.0));
    let statistic = (base - left).max(0.0) / added / inflation / (left / equations as f64);
    tail(added, count, statistic).max(1e-300)
}

/// Probability that a variable of the F-distribution of these freedoms is larger; 1 where the statistic is no number, for then
/// nothing was compared: no residual at all, or squares that overflow.
pub(crate) fn tail(added: f64, count: f64, statistic: f64) -> f64 {
    let distribution = FisherSnedecor::new(added, count).ok().filter(|_| statistic.is_finite() && count.is_finite());
    distribution.map_or(1.0, |f| f.sf(statistic))
}

/// How many neighbouring equations count as one: one plus twice the tapered autocorrelations over 0.1 s.
pub(super) fn inflation(problem: &Problem, residual: &DVector<f64>) -> f64 {
    let reach_s = 0.1;
    let equations = &problem.equations[..problem.fitted_equations()];
    let (mut cross, mut squares) = (0.0, 0.0);
    for i in 0..equations.len() {
        squares += residual[i] * residual[i];
        for j in i + 1..equations.len() {
            let apart_s = equations[j].row.centre_s - equations[i].row.centre_s;
            if equations[j].recording != equations[i].recording || apart_s > reach_s {
                break;
            }
            cross += (1.0 - apart_s / reach_s) * residual[i] * residual[j];
        }
    }
    (1.0 + 2.0 * cross / squares.max(1e-300)).max(1.0)
}
