//! Intervals from the sandwich of scores summed over blocks: honest where residuals are coloured.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::refit::TimeFit;
use crate::screen::{Active, Fit, Problem};

/// Covariance of the free values of a fit.
#[derive(Debug, Clone)]
pub struct Covariance {
    matrix: DMatrix<f64>,
    quantile: f64,
}

impl Covariance {
    /// Of a fit in the weak form.
    pub fn new(problem: &Problem, fit: &Fit, inflation: f64) -> Self {
        let count = fit.freedom();
        let normal = fit.jacobian.tr_mul(&fit.jacobian);
        let mut scores = vec![DVector::<f64>::zeros(count); problem.blocks];
        for (index, equation) in problem.equations.iter().enumerate() {
            scores[equation.block] += fit.jacobian.row(index).transpose() * fit.residual[index];
        }
        let variance = fit.sse / (fit.residual.len() as f64 - count as f64).max(1.0);
        Self::from_scores(&normal, &scores, variance * inflation)
    }

    /// Of a fit in the time domain, whose whitened residuals do not share their noise.
    pub fn of_time(fit: &TimeFit) -> Self {
        let variance = fit.sse / (fit.freedom - fit.normal.nrows() as f64).max(1.0);
        Self::from_scores(&fit.normal, &fit.scores, variance)
    }

    /// Scores (derivatives by residual) are summed over blocks, so that what is correlated within one counts once; where
    /// few blocks inform a value, the homoscedastic estimate for a variance of each residual is wider and is taken.
    fn from_scores(normal: &DMatrix<f64>, scores: &[DVector<f64>], variance: f64) -> Self {
        let count = normal.nrows();
        let inverse = scaled_inverse(normal);
        let used = scores.iter().filter(|score| score.norm_squared() > 0.0).count().max(2) as f64;
        let mut middle = DMatrix::<f64>::zeros(count, count);
        for score in scores {
            middle += score * score.transpose();
        }
        let clustered = &inverse * middle * &inverse * (used / (used - 1.0));
        let plain = &inverse * variance;
        let matrix = DMatrix::from_fn(count, count, |r, c| {
            let (wide_r, wide_c) = (widening(&clustered, &plain, r), widening(&clustered, &plain, c));
            clustered[(r, c)] * wide_r * wide_c
        });
        let quantile = StudentsT::new(0.0, 1.0, (used - 1.0).max(2.0)).map_or(2.0, |t| t.inverse_cdf(0.975));
        Self { matrix, quantile }
    }
}

fn widening(clustered: &DMatrix<f64>, plain: &DMatrix<f64>, index: usize) -> f64 {
    let (have, want) = (clustered[(index, index)].max(1e-300), plain[(index, index)]);
    if want > have { (want / have).sqrt() } else { 1.0 }
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
    let free = slopes.ncols();
    (0..reported.len())
        .map(|row| {
            let mut variance = 0.0;
            for i in 0..free {
                for j in 0..free {
                    variance += slopes[(row, i)] * covariance.matrix[(first + i, first + j)] * slopes[(row, j)];
                }
            }
            (reported[row], covariance.quantile * variance.max(0.0).sqrt())
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
