//! Rao's score test of columns beside those of a hypothesis, with the spread that blocks show.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::confidence_set::add_spread;
use crate::hypothesis::{Hypothesis, Kept, columns};
use crate::problem::Problem;

/// What a hypothesis leaves, recordings one behind the other.
pub(super) struct Left {
    residual: Vec<f64>,
    weight: Vec<f64>,
    /// The columns of the hypothesis itself, each without those before it and scaled to squares that sum to one.
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
    /// Share of the squares, or of those that noise would leave where these are more, less what as many columns take by chance.
    pub(super) share: f64,
    pub(super) p_value: f64,
}

impl Left {
    pub(super) fn new(problem: &Problem, hypothesis: &Hypothesis, path: &Kept) -> Self {
        let mut first = 0;
        let mut blocks = Vec::new();
        for (index, kept) in path.recordings.iter().enumerate() {
            blocks.push(problem.blocks[index].iter().map(|block| first + block.start..first + block.end).collect());
            first += kept.innovations.whitened.len();
        }
        let (residual, weight) = path.weighted();
        let mut left = Self { residual, weight, own: Vec::new(), blocks };
        for column in columns(problem, hypothesis, path).into_iter().flatten() {
            let found = left.beside_own(&column.concat());
            left.own.extend(found.map(|(column, _)| column));
        }
        left
    }

    /// Tests columns; none where the own ones hold them, or where there are too few blocks to say.
    // Over 40 lines: statistic, coefficients and share of one regression.
    pub(super) fn test(&self, new: &[Vec<f64>]) -> Option<Tested> {
        let beside: Vec<Option<(Vec<f64>, f64)>> = new.iter().map(|column| self.beside_own(column)).collect();
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
        // One a row is what noise leaves; where no noise is as small as what is left, below the sensor's step, that is no part of it.
        let of_noise = self.weight.iter().filter(|weight| **weight > 0.0).count() as f64;
        // Correlated rows let chance take more than one square a column.
        let by_chance = (2.0 * rise / statistic).max(1.0) * freedom;
        let mut solved = coefficients.iter();
        let mut unscaled = |kept: &Option<(Vec<f64>, f64)>| {
            kept.as_ref().and_then(|(_, scale)| Some(scale * solved.next()?)).unwrap_or(0.0)
        };
        let coefficients = beside.iter().map(&mut unscaled).collect();
        let finite = ratio.is_finite() && ratio > 0.0 && rise.is_finite();
        finite.then(|| Tested {
            share: (2.0 * rise - by_chance) / squares.max(of_noise).max(f64::MIN_POSITIVE),
            coefficients,
            rise,
            p_value: FisherSnedecor::new(freedom, rest).map_or(1.0, |f| f.sf(ratio)),
        })
    }

    fn dot(&self, one: &[f64], other: &[f64], rows: Range<usize>) -> f64 {
        rows.map(|row| self.weight[row] * one[row] * other[row]).sum()
    }

    /// What the own columns leave of another, scaled to squares that sum to one, with its scale; none where they hold it.
    fn beside_own(&self, column: &[f64]) -> Option<(Vec<f64>, f64)> {
        let all = 0..self.residual.len();
        let before = self.dot(column, column, all.clone());
        let mut column = column.to_vec();
        // Gram and Schmidt, twice: once leaves what rounding makes of collinear ones.
        for _ in 0..2 {
            for one in &self.own {
                let by = self.dot(one, &column, all.clone());
                column.iter_mut().zip(one).for_each(|(value, one)| *value -= by * one);
            }
        }
        let after = self.dot(&column, &column, all);
        // A column of which less than this is left is one of the others.
        let scale = after.sqrt().recip();
        (after > 1e-6 * before && scale.is_finite())
            .then(|| (column.iter().map(|value| value * scale).collect(), scale))
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
            add_spread(&mut spread, &scores);
        }
        (spread * (blocks as f64 / (blocks as f64 - 1.0).max(1.0)), blocks)
    }
}
