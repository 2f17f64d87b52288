//! Bands of shares, from whole blocks drawn again: neighbouring residuals are not independent, blocks nearly are.

use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

/// Draws.
const RESAMPLES: usize = 200;
/// The same answer every time.
const SEED: u64 = 1;

/// A share of the excess with its 95 % band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Share {
    pub share: f64,
    pub low: f64,
    pub high: f64,
}

/// Share of the total that a part has; both are sums of excess in each block.
pub(super) fn share(part: &[f64], total: &[f64]) -> Share {
    let used: Vec<usize> = (0..total.len()).filter(|&block| total[block] != 0.0).collect();
    let over = |blocks: &mut dyn Iterator<Item = usize>| {
        let (part, total) = blocks.fold((0.0, 0.0), |(p, t), block| (p + part[block], t + total[block]));
        if total > 0.0 { (part / total).clamp(0.0, 1.0) } else { 0.0 }
    };
    let share = over(&mut used.iter().copied());
    if used.is_empty() {
        return Share { share, low: share, high: share };
    }
    let mut random = StdRng::seed_from_u64(SEED);
    let mut drawn: Vec<f64> =
        (0..RESAMPLES).map(|_| over(&mut (0..used.len()).map(|_| used[random.random_range(0..used.len())]))).collect();
    drawn.sort_by(f64::total_cmp);
    let at = |quantile: f64| drawn[(quantile * (RESAMPLES - 1) as f64).round() as usize];
    Share { share, low: at(0.025).min(share), high: at(0.975).max(share) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_of_many_like_blocks_is_sure_and_of_one_block_is_not() {
        let total = vec![10.0; 50];
        let even = share(&vec![4.0; 50], &total);
        assert!((even.share - 0.4).abs() < 1e-12 && even.high - even.low < 1e-12, "{even:?}");
        let mut one = vec![0.0; 50];
        one[17] = 10.0;
        let one = share(&one, &total);
        assert!(one.low == 0.0 && one.share == 0.02 && one.high > 0.04, "{one:?}");
    }

    #[test]
    fn half_the_blocks_have_the_band_of_a_binomial() {
        let half: Vec<f64> = (0..100).map(|block| if block % 2 == 0 { 1.0 } else { 0.0 }).collect();
        let half = share(&half, &[1.0; 100]);
        // 1.96 sqrt(0.25/100) is 0.098.
        assert!((half.low - 0.402).abs() < 0.03 && (half.high - 0.598).abs() < 0.03, "{half:?}");
    }

    #[test]
    fn without_excess_there_is_no_share() {
        assert_eq!(share(&[0.0], &[0.0]), Share { share: 0.0, low: 0.0, high: 0.0 });
        assert_eq!(share(&[1.0, 0.0], &[1.0, -4.0]).share, 0.0);
    }
}
