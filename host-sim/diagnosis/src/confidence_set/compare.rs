//! Two hypotheses on the same blocks.

use std::ops::Range;

use statrs::distribution::{ContinuousCDF, Normal};

use super::{Assessed, Step};
use crate::hypothesis::{Evaluation, evaluate};
use crate::likelihood::Innovations;
use crate::likelihood::filter::loss;
use crate::problem::Problem;

/// How much better one is than another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Log-likelihood by which it is better, each at its own noise.
    pub difference: f64,
    /// The same under one noise, in standard deviations of what chance does to it.
    pub z: f64,
    /// Signed-rank statistic of the blocks (Wilcoxon 1945), standardised: a few wild blocks do not hide the many.
    pub rank_z: f64,
    /// The same of the windows of the longer horizon, by the logarithm of their squares (Diebold and Mariano 1995): what one
    /// step hides shows over many.
    pub window_z: f64,
}

impl Comparison {
    /// Probability that chance alone makes it that much better: three times that of the most certain of the three tests, whichever
    /// of the two that speaks for, and no less than one over the likelihood ratio, at which the worse of two hypotheses looks so much
    /// better at most (Royall 2000). A difference that is the same in every block, as of a value more, is certain to a test over blocks
    /// however little it is.
    pub fn p_value(&self) -> f64 {
        let most_certain = |most: f64, z: f64| if z.abs() > most.abs() { z } else { most };
        let z = [self.rank_z, self.window_z].into_iter().fold(self.z, most_certain);
        let by_the_tests = 3.0 * Normal::standard().cdf(-z);
        by_the_tests.max((-self.difference).exp()).min(1.0)
    }
}

/// Significance at which a rival is held to be worse, over all rivals together.
pub const LEVEL_OF_THE_SET: f64 = 0.05;

/// Which rivals are worse than the best, by Holm's step-down test (1979) of all of them together.
pub fn excluded(better: &[Comparison]) -> Vec<bool> {
    let mut order: Vec<usize> = (0..better.len()).collect();
    order.sort_by(|a, b| better[*a].p_value().total_cmp(&better[*b].p_value()));
    let mut excluded = vec![false; better.len()];
    for (step, &rival) in order.iter().enumerate() {
        if better[rival].p_value() >= LEVEL_OF_THE_SET / (better.len() - step) as f64 {
            break;
        }
        excluded[rival] = true;
    }
    excluded
}

/// Neighbouring blocks whose differences are taken to be correlated (Newey and West 1987).
const LAGS: usize = 2;

/// Vuong's test (1989) for a motion that is given and not drawn: what the distance of the two predictions makes a block
/// expect is no chance, the rest of the block's difference is. Both under one noise, the mean of what it is under that of either: at a
/// noise of its own each, the smaller one would be likelier at every standstill too, of which both predict the same.
pub fn compare(problem: &Problem, better: &Step, other: &Step) -> Comparison {
    let window_z = signed_rank(&better.windows.log_ratios(&other.windows));
    let (better, other) = (&better.assessed, &other.assessed);
    let (one, two) = (&better.refitted.evaluation, &other.refitted.evaluation);
    let exchanged = under_the_noise_of(problem, better, other).zip(under_the_noise_of(problem, other, better));
    let (one_there, two_there) = exchanged.as_ref().map_or((one, two), |(one, two)| (one, two));
    let mut expected: Vec<Vec<f64>> = Vec::new();
    let mut differences: Vec<Vec<f64>> = Vec::new();
    for index in 0..problem.recordings.len() {
        let blocks = &problem.blocks[index];
        let here = distances(&one.innovations[index], &two_there.innovations[index], blocks);
        let there = distances(&one_there.innovations[index], &two.innovations[index], blocks);
        expected.push(here.iter().zip(&there).map(|(here, there)| 0.5 * (here + there)).collect());
        let moved = |block: usize| {
            let by_noise = |own: &Evaluation, there: &Evaluation| own.blocks[index][block] - there.blocks[index][block];
            0.5 * (by_noise(two, two_there) - by_noise(one, one_there))
        };
        let own = better.crossed[index].iter().zip(&other.crossed[index]).map(|(one, two)| one - two);
        differences.push(own.enumerate().map(|(block, own)| own + moved(block)).collect());
    }
    let all: Vec<f64> = differences.iter().flatten().copied().collect();
    let z = all.iter().sum::<f64>() / standard_deviation(&expected, &differences);
    Comparison { difference: better.total() - other.total(), z, rank_z: signed_rank(&all), window_z }
}

/// Of the sum of the blocks' differences, about the share of what is expected of them that they have: Newey and West's, but at least that
/// of two predictions so far apart under equal fits, the square root of twice what is expected.
fn standard_deviation(expected: &[Vec<f64>], differences: &[Vec<f64>]) -> f64 {
    let pairs = || expected.iter().flatten().zip(differences.iter().flatten());
    let product: f64 = pairs().map(|(e, d)| e * d).sum();
    let square: f64 = pairs().map(|(e, _)| e * e).sum();
    let share = if square > 0.0 { product / square } else { 0.0 };
    let mut variance = 0.0;
    for (expected, differences) in expected.iter().zip(differences) {
        let left: Vec<f64> = expected.iter().zip(differences).map(|(e, d)| d - share * e).collect();
        for (at, value) in left.iter().enumerate() {
            variance += value * value;
            for lag in 1..=LAGS.min(at) {
                variance += 2.0 * (1.0 - lag as f64 / (LAGS + 1) as f64) * value * left[at - lag];
            }
        }
    }
    let least = 2.0 * pairs().map(|(e, _)| e).sum::<f64>();
    variance.max(least).max(f64::MIN_POSITIVE).sqrt()
}

/// What a block's difference in log-likelihood is expected to be if the first predicts right.
fn distances(one: &Innovations, two: &Innovations, blocks: &[Range<usize>]) -> Vec<f64> {
    let distance = |row: usize| if one.counted[row] { 0.5 * loss(one.whitened[row] - two.whitened[row]) } else { 0.0 };
    blocks.iter().map(|block| block.clone().map(distance).sum()).collect()
}

/// One under the noise of another; none where a pass is not finite.
fn under_the_noise_of(problem: &Problem, one: &Assessed, other: &Assessed) -> Option<Evaluation> {
    let physics = one.refitted.hypothesis.physics(&problem.nominal);
    evaluate(problem, &physics, &other.refitted.noise, 0..problem.recordings.len())
}

/// Neighbouring blocks are summed in pairs: what is left of their correlation is small against a pair.
fn signed_rank(differences: &[f64]) -> f64 {
    let mut pairs: Vec<f64> = differences.chunks(2).map(|pair| pair.iter().sum()).filter(|sum| *sum != 0.0).collect();
    pairs.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let n = pairs.len() as f64;
    let sum: f64 = pairs.iter().enumerate().map(|(at, value)| (at + 1) as f64 * value.signum()).sum();
    let variance = n * (n + 1.0) * (2.0 * n + 1.0) / 6.0;
    if variance > 0.0 { sum / variance.sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_test_excludes_a_rival_that_is_about_as_likely() {
        // An asymmetric lag of the field of two equal paces beside the lag that it is, 2.3 units likelier with one value less.
        for (difference, is_excluded) in [(-2.3, false), (2.9, false), (3.1, true)] {
            let by_windows = Comparison { difference, z: -1.7, rank_z: -2.0, window_z: 2.33 };
            assert_eq!(excluded(&[by_windows]), [is_excluded], "{difference}");
        }
        let by_blocks = |difference| Comparison { difference, z: 5.5, rank_z: 3.8, window_z: 0.0 };
        // An asymmetry of friction that is there, beside the offset that has one value less: the price of it in every block.
        assert_eq!(excluded(&[by_blocks(20.0), by_blocks(1.1)]), [true, false]);
    }

    #[test]
    fn of_tests_that_contradict_each_other_the_more_certain_one_counts() {
        // A cart behind a proportional loop: likelier in every block with a filtered torque, nearer to its windows with drag.
        for (window_z, is_excluded) in [(-3.98, false), (-3.5, true)] {
            let cart = Comparison { difference: 95.3, z: 2.79, rank_z: 3.72, window_z };
            assert_eq!(excluded(&[cart]), [is_excluded], "{window_z}");
        }
    }
}
