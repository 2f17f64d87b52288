//! Two hypotheses on the same blocks.

use statrs::distribution::{ContinuousCDF, Normal};

use super::Step;
use crate::problem::Problem;

/// How much better one is than another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Log-likelihood by which it is better.
    pub difference: f64,
    /// That in standard deviations of what chance does to it.
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
/// expect is no chance, the rest of the block's difference is.
pub fn compare(problem: &Problem, better: &Step, other: &Step) -> Comparison {
    let window_z = signed_rank(&better.windows.log_ratios(&other.windows));
    let (better, other) = (&better.assessed, &other.assessed);
    let mut expected: Vec<Vec<f64>> = Vec::new();
    let mut differences: Vec<Vec<f64>> = Vec::new();
    for index in 0..problem.recordings.len() {
        let (one, two) =
            (&better.refitted.evaluation.innovations[index], &other.refitted.evaluation.innovations[index]);
        let distance = |row: usize| {
            if one.counted[row] { 0.5 * (one.whitened[row] - two.whitened[row]).powi(2).min(64.0) } else { 0.0 }
        };
        expected.push(problem.blocks[index].iter().map(|block| block.clone().map(distance).sum()).collect());
        differences.push(better.crossed[index].iter().zip(&other.crossed[index]).map(|(a, b)| a - b).collect());
    }
    let flat = |values: &[Vec<f64>]| values.iter().flatten().copied().collect::<Vec<f64>>();
    let (all_expected, all) = (flat(&expected), flat(&differences));
    let product: f64 = all_expected.iter().zip(&all).map(|(e, d)| e * d).sum();
    let square: f64 = all_expected.iter().map(|e| e * e).sum();
    let share = if square > 0.0 { product / square } else { 0.0 };
    let mut variance = 0.0;
    for (expected, differences) in expected.iter().zip(&differences) {
        let left: Vec<f64> = expected.iter().zip(differences).map(|(e, d)| d - share * e).collect();
        for (at, value) in left.iter().enumerate() {
            variance += value * value;
            for lag in 1..=LAGS.min(at) {
                variance += 2.0 * (1.0 - lag as f64 / (LAGS + 1) as f64) * value * left[at - lag];
            }
        }
    }
    let difference: f64 = all.iter().sum();
    // Under equal fits the difference of two predictions spreads by at least the square root of twice what it is.
    let least = all_expected.iter().sum::<f64>() * 2.0;
    let sd = variance.max(least).max(f64::MIN_POSITIVE).sqrt();
    Comparison { difference, z: difference / sd, rank_z: signed_rank(&all), window_z }
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
        for (window_z, is_excluded) in [(-3.98, false), (-2.5, true)] {
            let cart = Comparison { difference: 95.3, z: 1.88, rank_z: 2.94, window_z };
            assert_eq!(excluded(&[cart]), [is_excluded], "{window_z}");
        }
    }
}
