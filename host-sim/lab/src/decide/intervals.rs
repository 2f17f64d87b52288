//! Intervals from the jackknife over blocks of time: honest where residuals are coloured.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::screen::{Active, Fit, Problem};

/// A block that holds all that is known of a value leaves nothing to compare it with; this share of the whole is kept.
const KEPT: f64 = 0.05;
/// Normal quantile of a two-sided 95 %.
const NORMAL: f64 = 1.96;

/// Covariance of the free values of a fit.
#[derive(Debug, Clone)]
pub struct Covariance {
    /// What leaving out one block after the other changes.
    clustered: DMatrix<f64>,
    /// As if all residuals had the same variance.
    plain: DMatrix<f64>,
    /// What each block adds to the second.
    shares: Vec<DMatrix<f64>>,
}

/// What one block knows of the free values.
#[derive(Debug, Clone)]
pub struct Block {
    /// Derivatives by derivatives.
    pub normal: DMatrix<f64>,
    /// Derivatives by residual.
    pub score: DVector<f64>,
}

impl Block {
    /// One that knows nothing of so many values.
    pub fn empty(values: usize) -> Self {
        Self { normal: DMatrix::zeros(values, values), score: DVector::zeros(values) }
    }
}

impl Covariance {
    /// Of a fit in the weak form; `inflation` is how many neighbouring equations count as one.
    pub fn new(problem: &Problem, fit: &Fit, inflation: f64) -> Self {
        let count = fit.jacobian.ncols();
        let mut blocks = vec![Block::empty(count); problem.blocks];
        for (index, equation) in problem.equations.iter().enumerate() {
            let (row, block) = (fit.jacobian.row(index).transpose(), &mut blocks[equation.block]);
            block.score += &row * fit.residual[index];
            block.normal += &row * row.transpose();
        }
        let variance = fit.sse / (fit.residual_count() - count as f64).max(1.0);
        Self::of_blocks(&blocks, count, variance * inflation)
    }

    /// Of `count` values from what blocks of time know of them: the jackknife over blocks, so that what is correlated
    /// within one counts once, and a block that knows much counts for it (Bell and McCaffrey, Survey Methodology 28, 2002,
    /// there as the estimate that is never too small). `variance` is that of one residual.
    pub fn of_blocks(blocks: &[Block], count: usize, variance: f64) -> Self {
        let normal = blocks.iter().fold(DMatrix::zeros(count, count), |sum, block| sum + &block.normal);
        let inverse = scaled_inverse(&normal);
        let used: Vec<&Block> = blocks.iter().filter(|block| block.normal.norm_squared() > 0.0).collect();
        let mut clustered = DMatrix::<f64>::zeros(count, count);
        for block in &used {
            let mut others = &normal - &block.normal;
            (0..count).for_each(|index| others[(index, index)] += KEPT * normal[(index, index)]);
            let change = scaled_inverse(&others) * &block.score;
            clustered += &change * change.transpose();
        }
        let shares = used.iter().map(|block| &inverse * &block.normal * &inverse).collect();
        Self { clustered, plain: inverse * variance, shares }
    }

    /// Half-width of the 95 % interval of a combination of the values. The blocks that inform it are as many degrees of
    /// freedom as have the same sum of squared shares (Satterthwaite). Where few inform it, as with a push, the estimate
    /// for equal variances is wider and is taken.
    fn half_width(&self, combination: &DVector<f64>) -> f64 {
        let of = |matrix: &DMatrix<f64>| combination.dot(&(matrix * combination)).max(0.0);
        let (sum, squares) =
            self.shares.iter().map(of).fold((0.0, 0.0), |(sum, squares), v| (sum + v, squares + v * v));
        let blocks = if squares > 0.0 { sum * sum / squares } else { 1.0 };
        let quantile = StudentsT::new(0.0, 1.0, (blocks - 1.0).max(2.0)).map_or(NORMAL, |t| t.inverse_cdf(0.975));
        (quantile * of(&self.clustered).sqrt()).max(NORMAL * of(&self.plain).sqrt())
    }
}

fn scaled_inverse(normal: &DMatrix<f64>) -> DMatrix<f64> {
    let count = normal.nrows();
    let scale: Vec<f64> =
        (0..count).map(|i| if normal[(i, i)] > 0.0 { 1.0 / normal[(i, i)].sqrt() } else { 0.0 }).collect();
    let scaled =
        DMatrix::from_fn(count, count, |r, c| normal[(r, c)] * scale[r] * scale[c] + if r == c { 1e-10 } else { 0.0 });
    let inverse = scaled.try_inverse().unwrap_or_else(|| DMatrix::identity(count, count));
    DMatrix::from_fn(count, count, |r, c| inverse[(r, c)] * scale[r] * scale[c])
}

/// Reported values of one effect of a model with the half-widths of their 95 % intervals.
pub fn intervals(active: &[Active], covariance: &Covariance, index: usize) -> Vec<(f64, f64)> {
    let entry = &active[index];
    let first: usize = active[..index].iter().map(|other| other.effect.freedom(&other.values)).sum();
    let reported = (entry.effect.report)(&entry.values);
    let slopes = slopes(entry, reported.len());
    let size = covariance.plain.nrows();
    (0..reported.len())
        .map(|row| {
            let mut combination = DVector::zeros(size);
            (0..slopes.ncols()).for_each(|column| combination[first + column] = slopes[(row, column)]);
            (reported[row], covariance.half_width(&combination))
        })
        .collect()
}

/// Derivatives of the reported by the free fitted values.
fn slopes(entry: &Active, count: usize) -> DMatrix<f64> {
    let free: Vec<usize> = (0..entry.values.len()).filter(|&value| entry.effect.parameter(value).free).collect();
    let mut slopes = DMatrix::zeros(count, free.len());
    for (column, &value) in free.iter().enumerate() {
        let step = 1e-6 * entry.values[value].abs().max(entry.ranges[value].scale);
        let at = |change: f64| {
            let mut values = entry.values.clone();
            values[value] += change;
            (entry.effect.report)(&values)
        };
        let (above, below) = (at(step), at(-step));
        for row in 0..count {
            slopes[(row, column)] = (above[row] - below[row]) / (2.0 * step);
        }
    }
    slopes
}

#[cfg(test)]
mod tests {
    use rand::rngs::StdRng;
    use rand::{Rng, SeedableRng};
    use rand_distr::StandardNormal;

    use super::*;

    /// A mean of blocks, some of which know ten times as much; residuals share half their variance within a block.
    #[test]
    fn intervals_hold_the_truth_with_shared_noise_and_unequal_blocks() {
        let mut rng = StdRng::seed_from_u64(7);
        let mut draw = || -> f64 { rng.sample(StandardNormal) };
        let mut held = 0;
        for _ in 0..400 {
            let rows: Vec<(usize, f64)> = (0..24)
                .flat_map(|block| {
                    let shared = draw();
                    let rows = if block % 6 == 0 { 40 } else { 4 };
                    (0..rows).map(|_| (block, shared + draw())).collect::<Vec<_>>()
                })
                .collect();
            let mean = rows.iter().map(|(_, value)| value).sum::<f64>() / rows.len() as f64;
            let mut blocks = vec![Block::empty(1); 24];
            for (block, value) in rows {
                blocks[block].normal[(0, 0)] += 1.0;
                blocks[block].score[0] += value - mean;
            }
            let half = Covariance::of_blocks(&blocks, 1, 2.0).half_width(&DVector::from_element(1, 1.0));
            held += i32::from(mean.abs() <= half);
        }
        assert!((370..=398).contains(&held), "{held} of 400");
    }
}
