//! Interpolation on the Chebyshev points of [-1, 0], as rows to multiply the values at the points with.

use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// The points from 0 down to -1.
#[derive(Debug)]
pub(super) struct Chebyshev {
    points: Vec<f64>,
}

impl Chebyshev {
    /// `degree` + 1 points; `degree` is 1 or more.
    pub fn new(degree: usize) -> Self {
        Self { points: extrema(degree).iter().map(|x| 0.5 * (x - 1.0)).collect() }
    }

    /// The derivative at every point, one row each (Trefethen, Spectral Methods in MATLAB, chapter 6).
    pub fn derivative(&self) -> DMatrix<f64> {
        let size = self.points.len();
        let end = |k: usize| if k == 0 || k == size - 1 { 2.0 } else { 1.0 };
        let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        let mut matrix = DMatrix::from_fn(size, size, |i, k| {
            if i == k { 0.0 } else { end(i) * sign(i) / (end(k) * sign(k)) / (self.points[i] - self.points[k]) }
        });
        for i in 0..size {
            // A constant has no derivative: the diagonal is less the sum of the row, which also cancels rounding.
            matrix[(i, i)] = -matrix.row(i).sum();
        }
        matrix
    }

    /// The value at `x` of the polynomial through the points, by the barycentric formula.
    pub fn value_at(&self, x: f64) -> DVector<f64> {
        let size = self.points.len();
        if let Some(hit) = self.points.iter().position(|&point| (point - x).abs() < 1e-15) {
            return DVector::from_fn(size, |k, _| if k == hit { 1.0 } else { 0.0 });
        }
        let weights = DVector::from_fn(size, |k, _| {
            let end = if k == 0 || k == size - 1 { 0.5 } else { 1.0 };
            let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            sign * end / (x - self.points[k])
        });
        let sum = weights.sum();
        weights / sum
    }

    /// The integral from `x` to 0 of the polynomial through the points: Clenshaw and Curtis on [x, 0], exact for it.
    pub fn integral_from(&self, x: f64) -> DVector<f64> {
        let degree = self.points.len() - 1;
        let mut row = DVector::zeros(degree + 1);
        for (point, weight) in extrema(degree).iter().zip(clenshaw_curtis(degree)) {
            row += self.value_at(0.5 * (1.0 - point) * x) * (-0.5 * x * weight);
        }
        row
    }
}

/// cos(k pi / degree): from 1 down to -1.
fn extrema(degree: usize) -> Vec<f64> {
    (0..=degree).map(|k| (PI * ratio(k, degree)).cos()).collect()
}

/// Weights of the points of [`extrema`] in the integral over [-1, 1].
fn clenshaw_curtis(degree: usize) -> impl Iterator<Item = f64> {
    let half = degree / 2;
    (0..=degree).map(move |k| {
        let mut sum = 1.0;
        for j in 1..=half {
            let share = if 2 * j == degree { 1.0 } else { 2.0 };
            sum -= share * (2.0 * PI * ratio(j * k, degree)).cos() / (ratio(2 * j, 1).powi(2) - 1.0);
        }
        let end = if k == 0 || k == degree { 1.0 } else { 2.0 };
        end * sum / ratio(degree, 1)
    })
}

/// Exact for every size a matrix can have.
#[allow(clippy::cast_precision_loss)]
fn ratio(a: usize, b: usize) -> f64 {
    a as f64 / b as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_exact_for_an_exponential() {
        for degree in [15, 16] {
            let chebyshev = Chebyshev::new(degree);
            let values = DVector::from_iterator(degree + 1, chebyshev.points.iter().map(|x| (3.0 * x).exp()));
            let derivative = chebyshev.derivative() * &values;
            for (k, x) in chebyshev.points.iter().enumerate() {
                assert!((derivative[k] - 3.0 * (3.0 * x).exp()).abs() < 1e-10);
            }
            for x in [0.0, -0.013, -0.37, -1.0] {
                assert!((chebyshev.value_at(x).dot(&values) - (3.0 * x).exp()).abs() < 1e-12);
                let exact = (1.0 - (3.0 * x).exp()) / 3.0;
                assert!((chebyshev.integral_from(x).dot(&values) - exact).abs() < 1e-12, "{degree} {x}");
            }
        }
    }
}
