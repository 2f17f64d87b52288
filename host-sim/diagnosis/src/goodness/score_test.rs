//! Rao's score test of columns beside those of a hypothesis, with the spread that blocks show.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::hypothesis::{Hypothesis, Kept, columns};
use crate::likelihood::filter::HUBER;
use crate::problem::Problem;

/// Blocks whose scores are taken to be correlated with a block's own (Newey and West 1987): half a second either way.
const LAGS: usize = 2;

/// What a hypothesis leaves, recordings one behind the other.
pub(super) struct Left {
    residual: Vec<f64>,
    weight: Vec<f64>,
    own: Vec<Vec<f64>>,
    /// Row ranges of the blocks, one list a recording.
    blocks: Vec<Vec<Range<usize>>>,
}

/// What columns predict of it.
pub(super) struct Tested {
    /// One a column; 0 for one that others hold.
    pub(super) coefficients: Vec<f64>,
    /// Log-likelihood they add, to second order.
    pub(super) rise: f64,
    /// Share of the squares, less what as many columns take by chance.
    pub(super) share: f64,
    pub(super) p_value: f64,
}

impl Left {
    pub(super) fn new(problem: &Problem, hypothesis: &Hypothesis, path: &Kept) -> Self {
        let rows = || path.recordings.iter().map(|kept| &kept.innovations);
        let pairs = || rows().flat_map(|found| found.whitened.iter().zip(&found.counted));
        let mut first = 0;
        let mut blocks = Vec::new();
        for (index, found) in rows().enumerate() {
            blocks.push(problem.blocks[index].iter().map(|block| first + block.start..first + block.end).collect());
            first += found.whitened.len();
        }
        Self {
            residual: pairs().map(|(whitened, _)| *whitened).collect(),
            weight: pairs()
                .map(|(whitened, counted)| if *counted { (HUBER / whitened.abs()).min(1.0) } else { 0.0 })
                .collect(),
            own: columns(problem, hypothesis, path).into_iter().flatten().map(|column| column.concat()).collect(),
            blocks,
        }
    }

    /// Tests columns; none where the own ones hold them, or where there are too few blocks to say.
    pub(super) fn test(&self, new: &[Vec<f64>]) -> Option<Tested> {
        let beside = self.beside_own(new);
        let found: Vec<&Vec<f64>> = beside.iter().flatten().map(|(column, _)| column).collect();
        let many = found.len();
        if many == 0 {
            return None;
        }
        let mut information = DMatrix::zeros(many, many);
        let mut score = DVector::zeros(many);
        for i in 0..many {
            // A model that is this column more predicts a residual that is smaller by it.
            score[i] = -self.dot(found[i], &self.residual, 0..self.residual.len());
            for j in 0..=i {
                let product = self.dot(found[i], found[j], 0..self.residual.len());
                (information[(i, j)], information[(j, i)]) = (product, product);
            }
        }
        let (spread, blocks) = self.spread(&found, &score);
        if blocks <= many + 1 {
            return None;
        }
        let (freedom, rest) = (many as f64, (blocks - many) as f64);
        let statistic = score.dot(&spread.cholesky()?.solve(&score));
        let ratio = statistic * rest / (freedom * (blocks as f64 - 1.0));
        let coefficients = information.cholesky()?.solve(&score);
        let rise = 0.5 * coefficients.dot(&score);
        let squares: f64 = self.dot(&self.residual, &self.residual, 0..self.residual.len());
        // Correlated rows let chance take more than one square a column.
        let by_chance = (2.0 * rise / statistic).max(1.0) * freedom;
        let mut solved = coefficients.iter();
        let mut unscaled = |kept: &Option<(Vec<f64>, f64)>| {
            kept.as_ref().and_then(|(_, scale)| Some(scale * solved.next()?)).unwrap_or(0.0)
        };
        let coefficients = beside.iter().map(&mut unscaled).collect();
        let finite = ratio.is_finite() && ratio > 0.0 && rise.is_finite();
        finite.then(|| Tested {
            share: (2.0 * rise - by_chance) / squares.max(f64::MIN_POSITIVE),
            coefficients,
            rise,
            p_value: FisherSnedecor::new(freedom, rest).map_or(1.0, |f| f.sf(ratio)),
        })
    }

    fn dot(&self, one: &[f64], other: &[f64], rows: Range<usize>) -> f64 {
        rows.map(|row| self.weight[row] * one[row] * other[row]).sum()
    }

    /// What the own columns leave of others, each scaled to squares that sum to one, with its scale; none of one that they hold.
    fn beside_own(&self, new: &[Vec<f64>]) -> Vec<Option<(Vec<f64>, f64)>> {
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let all = 0..self.residual.len();
        // Gram and Schmidt, each column twice: once leaves what rounding makes of collinear ones.
        let left = |column: &[f64], basis: &[Vec<f64>]| -> Option<(Vec<f64>, f64)> {
            let before = self.dot(column, column, all.clone());
            let mut column = column.to_vec();
            for _ in 0..2 {
                for one in basis {
                    let by = self.dot(one, &column, all.clone());
                    column.iter_mut().zip(one).for_each(|(value, one)| *value -= by * one);
                }
            }
            let after = self.dot(&column, &column, all.clone());
            // A column of which less than this is left is one of the others.
            let scale = after.sqrt().recip();
            (after > 1e-6 * before && scale.is_finite())
                .then(|| (column.iter().map(|value| value * scale).collect(), scale))
        };
        for own in &self.own {
            let found = left(own, &basis);
            basis.extend(found.map(|(column, _)| column));
        }
        new.iter().map(|column| left(column, &basis)).collect()
    }

    /// Covariance of the score from that of its blocks about their mean, and the number of blocks that say something.
    fn spread(&self, new: &[&Vec<f64>], score: &DVector<f64>) -> (DMatrix<f64>, usize) {
        let many = new.len();
        let counts = |block: &Range<usize>| self.weight[block.clone()].iter().any(|weight| *weight > 0.0);
        let blocks = self.blocks.iter().flatten().filter(|block| counts(block)).count();
        let mean = score / blocks.max(1) as f64;
        let mut spread = DMatrix::zeros(many, many);
        for of_recording in &self.blocks {
            let scores: Vec<DVector<f64>> = of_recording
                .iter()
                .filter(|block| counts(block))
                .map(|block| {
                    DVector::from_iterator(many, new.iter().map(|one| -self.dot(one, &self.residual, block.clone())))
                        - &mean
                })
                .collect();
            for (at, score) in scores.iter().enumerate() {
                spread += score * score.transpose();
                for lag in 1..=LAGS.min(at) {
                    let cross = score * scores[at - lag].transpose();
                    spread += (&cross + cross.transpose()) * (1.0 - lag as f64 / (LAGS + 1) as f64);
                }
            }
        }
        (spread * (blocks as f64 / (blocks as f64 - 1.0).max(1.0)), blocks)
    }
}
