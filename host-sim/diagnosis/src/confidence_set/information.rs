//! Block scores and information of a hypothesis at its optimum: cross-validation without refits, and sandwich intervals.

use nalgebra::{DMatrix, DVector};

use super::intervals::{SMALLEST_SIZE, critical_value};
use super::profile::Profile;
use crate::hypothesis::{Hypothesis, Refitted, columns, kept, ranges};
use crate::likelihood::Noise;
use crate::problem::Problem;

/// A hypothesis with what its blocks say.
#[derive(Debug, Clone)]
pub struct Assessed {
    /// The hypothesis at its optimum.
    pub refitted: Refitted,
    /// Log-likelihood of each block: of recordings to fit under the values that the other blocks give, of recordings held out
    /// as it is.
    pub crossed: Vec<Vec<f64>>,
    /// Covariance of the free values, in the order of [`crate::hypothesis::Hypothesis::free`].
    pub covariance: DMatrix<f64>,
    /// Covariance of the free values if every row were independent.
    pub naive: DMatrix<f64>,
    /// Information of the free values.
    pub(super) information: DMatrix<f64>,
    /// Blocks that the covariance was estimated over.
    blocks: usize,
    /// What the likelihood itself says of the values beyond the quadratic that the covariance is; none until it was asked.
    pub(super) profile: Option<Profile>,
    /// Smallest relevant sizes of the free values.
    pub(super) smallest: Vec<f64>,
}

impl Assessed {
    /// Number of free values.
    pub fn freedom(&self) -> usize {
        self.refitted.hypothesis.entries.iter().map(|entry| entry.effect.freedom(&entry.values)).sum()
    }

    /// What a standard deviation is multiplied by for half a 95 % interval.
    pub fn critical_value(&self) -> f64 {
        critical_value(self.blocks, LAGS)
    }

    /// Sum of the blocks.
    pub fn total(&self) -> f64 {
        self.crossed.iter().flatten().sum()
    }

    /// Sum of the blocks of the recordings that judge.
    pub fn judged(&self, problem: &Problem) -> f64 {
        self.crossed[problem.judged()].iter().flatten().sum()
    }

    /// Largest correlation of a value of an entry with a value of another, 0 to 1.
    pub fn collinear(&self, entry: usize) -> f64 {
        let places = self.refitted.hypothesis.free();
        let mut largest = 0.0_f64;
        for (i, own) in places.iter().enumerate().filter(|(_, place)| place.0 == entry) {
            for (j, _) in places.iter().enumerate().filter(|(_, place)| place.0 != own.0) {
                let scale = (self.covariance[(i, i)] * self.covariance[(j, j)]).sqrt();
                let correlation = (self.covariance[(i, j)] / scale).abs();
                largest = if correlation.is_finite() { largest.max(correlation) } else { largest };
            }
        }
        largest
    }

    /// How many times more an entry's values scatter over blocks than independent rows would let them, at least 1.
    pub fn inflation(&self, entry: usize) -> f64 {
        let places = self.refitted.hypothesis.free();
        let ratio = |(i, &(at, _)): (usize, &(usize, usize))| {
            (at == entry).then(|| self.covariance[(i, i)] / self.naive[(i, i)])
        };
        places.iter().enumerate().filter_map(ratio).filter(|ratio| ratio.is_finite()).fold(1.0, f64::max)
    }

    /// What a likelihood ratio of an entry is divided by, at least 1, so that its mean is that of a chi squared though neighbouring rows
    /// are alike: the mean eigenvalue of the sandwich over the information (Rao and Scott 1984, first order). Their spread is not taken
    /// from the blocks: of ten that tell a value it is mostly chance.
    pub fn design_effect(&self, entry: usize) -> f64 {
        let places = self.refitted.hypothesis.free();
        let places: Vec<usize> = (0..places.len()).filter(|&at| places[at].0 == entry).collect();
        let of = |matrix: &DMatrix<f64>| matrix.select_rows(&places).select_columns(&places);
        let over = of(&self.naive).cholesky().map(|naive| naive.solve(&of(&self.covariance)).trace());
        let mean = over.map(|sum| sum / places.len() as f64).filter(|mean| mean.is_finite());
        mean.map_or_else(|| self.inflation(entry), |mean| mean.max(1.0))
    }
}

/// Blocks whose scores are taken to be correlated with a block's own (Newey and West 1987): half a second either way.
pub(super) const LAGS: usize = 2;

/// Scores and parts of the information of each block of each recording.
struct Linearised {
    scores: Vec<Vec<DVector<f64>>>,
    parts: Vec<Vec<DMatrix<f64>>>,
    /// Their sum, with a weak prior on each value.
    information: DMatrix<f64>,
}

fn linearised(problem: &Problem, hypothesis: &Hypothesis, noise: &[Noise]) -> Option<Linearised> {
    let alone = hypothesis.alone();
    let path = kept(problem, &hypothesis.physics(&problem.nominal), noise, hypothesis.told_by(problem))?;
    let still = || path.recordings.iter().map(|kept| vec![0.0; kept.innovations.whitened.len()]).collect();
    let columns: Vec<Vec<Vec<f64>>> =
        columns(problem, hypothesis, &path).into_iter().map(|column| column.unwrap_or_else(still)).collect();
    let many = columns.len();
    let mut scores: Vec<Vec<DVector<f64>>> = Vec::new();
    let mut parts: Vec<Vec<DMatrix<f64>>> = Vec::new();
    for (index, kept) in path.recordings.iter().enumerate() {
        let (mut of_scores, mut of_parts) = (Vec::new(), Vec::new());
        let told: Vec<bool> = alone.iter().map(|of| index < problem.fitted || *of == Some(index)).collect();
        for block in &problem.blocks[index] {
            let (mut score, mut part) = (DVector::zeros(many), DMatrix::zeros(many, many));
            kept.equations(&columns, index, &told).add_rows(block.clone(), &mut score, &mut part);
            part.fill_upper_triangle_with_lower_triangle();
            of_scores.push(score);
            of_parts.push(part);
        }
        scores.push(of_scores);
        parts.push(of_parts);
    }
    let mut information: DMatrix<f64> = parts.iter().flatten().sum::<DMatrix<f64>>();
    if many == 0 || information.nrows() == 0 {
        information = DMatrix::zeros(many, many);
    }
    for (i, range) in ranges(problem, hypothesis).iter().enumerate() {
        information[(i, i)] = information[(i, i)] * (1.0 + 1e-9) + 0.01 / (range.scale * range.scale);
    }
    Some(Linearised { scores, parts, information })
}

/// Linearises at the optimum.
pub fn assess(problem: &Problem, refitted: Refitted) -> Option<Assessed> {
    let Linearised { scores, parts, information } = linearised(problem, &refitted.hypothesis, &refitted.noise)?;
    let naive = information.clone().cholesky()?.inverse();
    let covariance = sandwich(&naive, &scores);
    let smallest = ranges(problem, &refitted.hypothesis).iter().map(|range| SMALLEST_SIZE * range.scale).collect();
    let crossed = crossed(problem, &refitted, &information, &scores, &parts);
    let blocks = scores.iter().map(Vec::len).sum();
    Some(Assessed { refitted, crossed, covariance, naive, information, blocks, profile: None, smallest })
}

/// The noise of a recording stands in for what its model leaves out, such as the shape of a sensor's rounding: on three tuning recordings
/// with known noise the likeliest torque density was one and a half to three times the true one. Values must not hang on that.
pub(crate) const OTHER_NOISE: f64 = 0.5;

impl Assessed {
    /// With what the values owe to the split of the noise between torque and sensor: the step they would take under another one.
    pub fn widened_by_noise(mut self, problem: &Problem) -> Option<Self> {
        let other: Vec<Noise> = self.refitted.noise.iter().map(|noise| noise.with_torque_share(OTHER_NOISE)).collect();
        let of = |noise: &[Noise]| {
            let Linearised { scores, information, .. } = linearised(problem, &self.refitted.hypothesis, noise)?;
            let score: DVector<f64> = scores.iter().flatten().sum();
            Some(information.cholesky()?.solve(&score))
        };
        if self.covariance.nrows() > 0 {
            let step = of(&other)? - of(&self.refitted.noise)?;
            self.covariance += &step * step.transpose();
        }
        Some(self)
    }
}

/// Adds the spread of one recording's block scores, in their order, with what neighbours have in common.
pub(crate) fn add_spread(spread: &mut DMatrix<f64>, scores: &[DVector<f64>]) {
    for (at, score) in scores.iter().enumerate() {
        *spread += score * score.transpose();
        for lag in 1..=LAGS.min(at) {
            let weight = 1.0 - lag as f64 / (LAGS + 1) as f64;
            let cross = score * scores[at - lag].transpose();
            *spread += (&cross + cross.transpose()) * weight;
        }
    }
}

/// Inverse information times the spread of the block scores times inverse information; never below what the information
/// alone says, for few blocks understate their own spread.
fn sandwich(inverse: &DMatrix<f64>, scores: &[Vec<DVector<f64>>]) -> DMatrix<f64> {
    let many = inverse.nrows();
    let mut spread = DMatrix::zeros(many, many);
    let mut blocks = 0_usize;
    for of_recording in scores {
        blocks += of_recording.len();
        add_spread(&mut spread, of_recording);
    }
    // Each estimated value takes one block's worth of freedom.
    let few = blocks as f64 / (blocks as f64 - many as f64).max(1.0);
    let mut covariance = inverse * spread * inverse * few;
    for i in 0..many {
        let least = inverse[(i, i)];
        if covariance[(i, i)] < least {
            let stretch = (least / covariance[(i, i)].max(f64::MIN_POSITIVE)).sqrt();
            if covariance[(i, i)] > 0.0 {
                covariance.row_mut(i).scale_mut(stretch);
                covariance.column_mut(i).scale_mut(stretch);
            } else {
                covariance[(i, i)] = least;
            }
        }
    }
    covariance
}

/// Log-likelihood of each block under the values without it, to second order; held-out blocks as they are.
fn crossed(
    problem: &Problem,
    refitted: &Refitted,
    information: &DMatrix<f64>,
    scores: &[Vec<DVector<f64>>],
    parts: &[Vec<DMatrix<f64>>],
) -> Vec<Vec<f64>> {
    let mut all = refitted.evaluation.blocks.clone();
    for (index, of_recording) in all.iter_mut().enumerate().take(problem.fitted) {
        for (block, value) in of_recording.iter_mut().enumerate() {
            let (score, part) = (&scores[index][block], &parts[index][block]);
            let rest = information - part;
            // A value that this block alone tells is not judged by leaving it out.
            if let Some(rest) = rest.cholesky() {
                let moved = -rest.solve(score);
                let change = score.dot(&moved) - 0.5 * (moved.transpose() * part * &moved)[(0, 0)];
                if change.is_finite() {
                    *value += change.max(-MOST_LOST);
                }
            }
        }
    }
    all
}

/// A block that tells a value alone would lose any amount without it; what it tells then counts as found once, at the price
/// of a few values.
const MOST_LOST: f64 = 10.0;
