//! The test that tells two models apart, and how probably it will.

use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, Gamma, StandardNormal};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::noise::Noise;

/// Two models are told apart at this one-sided p-value.
pub const P_VALUE: f64 = 1e-3;
/// Drawn recordings for one power: its own uncertainty is at most 0.025.
const DRAWS: usize = 400;
/// Of the draws; the same for every reference and pair.
pub(super) const SEED: u64 = 1;

/// What a rival leaves in one block beyond the noise.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Block {
    /// Windows in it.
    pub windows: f64,
    /// Sum of squares of the difference, rad2 (m2).
    pub energy: f64,
    /// Variance of the noise along it, rad4 (m4).
    pub variance: f64,
}

/// t of the rise of the blocks' sums of squares from the right model to the rival, paired over blocks: of the rise itself,
/// or of the rise relative to the size of both, whichever is larger. The first sees most where the noise is the same in all
/// blocks; the second does not let a few blocks with much motion outweigh all others.
pub(super) fn paired_t(right_and_rival: &[(f64, f64)]) -> f64 {
    let some = || right_and_rival.iter().filter(|(a, b)| a + b > 0.0);
    t_of_mean(some().map(|(a, b)| b - a).collect()).max(t_of_mean(some().map(|(a, b)| (b - a) / (a + b)).collect()))
}

fn t_of_mean(changes: Vec<f64>) -> f64 {
    let count = changes.len() as f64;
    if count < 3.0 {
        return 0.0;
    }
    let mean = changes.iter().sum::<f64>() / count;
    let variance = changes.iter().map(|c| (c - mean) * (c - mean)).sum::<f64>() / (count - 1.0);
    mean / (variance / count).sqrt().max(1e-300)
}

/// The t that so many blocks must pass to be significant at [`P_VALUE`], two tests counted.
pub(super) fn critical_t(blocks: usize) -> f64 {
    let freedom = (blocks as f64 - 1.0).max(1.0);
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(1.0 - 0.5 * P_VALUE))
}

/// Probability that the test tells them apart, over drawn noise, where the blocks come `repeats` times.
pub(super) fn power(blocks: &[Block], repeats: usize, noise: &Noise) -> f64 {
    let count = blocks.len() * repeats;
    if count < 3 || blocks.iter().all(|block| block.energy == 0.0) {
        return 0.0;
    }
    let critical = critical_t(count);
    let mut random = StdRng::seed_from_u64(SEED);
    let draws: Vec<Option<Gamma<f64>>> = blocks.iter().map(|block| squares(block.windows, noise)).collect();
    let found = (0..DRAWS).filter(|_| {
        let pairs = (0..count).map(|index| {
            let (block, draw) = (&blocks[index % blocks.len()], &draws[index % blocks.len()]);
            let right = draw.as_ref().map_or(0.0, |draw| draw.sample(&mut random));
            let normal: f64 = StandardNormal.sample(&mut random);
            // The difference adds its own squares and twice its product with the noise; no sum of squares is negative.
            (right, (right + block.energy + 2.0 * block.variance.sqrt() * normal).max(0.0))
        });
        paired_t(&pairs.collect::<Vec<_>>()) > critical
    });
    found.count() as f64 / DRAWS as f64
}

/// Distribution of the noise's sum of squares in a block of so many windows.
fn squares(windows: f64, noise: &Noise) -> Option<Gamma<f64>> {
    let shape = 0.5 * noise.freedom * windows;
    Gamma::new(shape, noise.energy * windows / shape).ok()
}

/// Root of the difference's squares over the noise along it, summed over blocks: the number of standard deviations by
/// which a test that knew the difference would see it. Orders references whose powers are equal.
pub(super) fn noncentrality(blocks: &[Block]) -> f64 {
    let each = blocks.iter().filter(|block| block.variance > 0.0).map(|block| block.energy.powi(2) / block.variance);
    each.sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_rises_from_nothing_to_certainty() {
        let noise = Noise::new(4e-6, 3.9e-6, 100, 5e-4);
        let block = |size: f64| {
            let difference = vec![size; 100];
            let (energy, variance) = (size * size * 100.0, noise.variance_along(&difference));
            Block { windows: 4.0, energy: 4.0 * energy, variance: 4.0 * variance }
        };
        let at = |size: f64, repeats| power(&vec![block(size); 20], repeats, &noise);
        assert_eq!(at(0.0, 1), 0.0);
        let powers: Vec<f64> = [1e-8, 3e-7, 6e-7, 1e-6, 4e-6].map(|size| at(size, 1)).to_vec();
        assert!(powers.is_sorted() && powers[0] < 0.02 && powers[4] == 1.0, "{powers:?}");
        assert!(at(2.5e-7, 4) > at(2.5e-7, 1) + 0.1, "more time tells more");
        assert_eq!(at(2.5e-7, 2), at(2.5e-7, 2), "the seed is fixed");
    }

    #[test]
    fn a_difference_in_one_block_only_does_not_convince() {
        let noise = Noise::new(4e-6, 3.9e-6, 100, 5e-4);
        let quiet = Block { windows: 4.0, ..Block::default() };
        let mut blocks = vec![quiet; 20];
        blocks[3] = Block { energy: 1.0, variance: 1e-12, ..quiet };
        assert!(power(&blocks, 1, &noise) < 0.05);
    }
}
