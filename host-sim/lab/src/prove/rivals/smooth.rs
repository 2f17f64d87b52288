//! Savitzky-Golay filter (A. Savitzky, M. J. E. Golay, 1964): a cubic fitted to each stretch of samples.

use nalgebra::{Matrix4, Vector4};

/// Samples to either side: 41 samples are 20 ms at 2 kHz.
pub(super) const HALF: usize = 20;

/// Kernels of value, slope and curvature for samples a unit apart.
#[derive(Debug, Clone)]
pub(super) struct Kernels([Vec<f64>; 3]);

impl Kernels {
    /// None only for a window too short for a cubic.
    pub(super) fn new() -> Option<Self> {
        let half = HALF as f64;
        let powers = |k: usize| {
            let x = (k as f64 - half) / half;
            Vector4::new(1.0, x, x * x, x * x * x)
        };
        let gram: Matrix4<f64> = (0..=2 * HALF).map(|k| powers(k) * powers(k).transpose()).sum();
        let inverse = gram.try_inverse()?;
        let kernel = |order: usize, factor: f64| {
            let weight = |k: usize| (inverse.row(order) * powers(k))[0] * factor;
            (0..=2 * HALF).map(weight).collect::<Vec<f64>>()
        };
        Some(Self([kernel(0, 1.0), kernel(1, 1.0 / half), kernel(2, 2.0 / (half * half))]))
    }

    /// Value, slope and curvature of the signal around sample `at`, for samples `period` apart.
    pub(super) fn at(&self, signal: &[f64], at: usize, period: f64) -> [f64; 3] {
        let stretch = &signal[at - HALF..=at + HALF];
        let dot = |kernel: &[f64]| kernel.iter().zip(stretch).map(|(weight, value)| weight * value).sum::<f64>();
        [dot(&self.0[0]), dot(&self.0[1]) / period, dot(&self.0[2]) / (period * period)]
    }

    /// Value alone.
    pub(super) fn value(&self, signal: &[f64], at: usize) -> f64 {
        self.0[0].iter().zip(&signal[at - HALF..=at + HALF]).map(|(weight, value)| weight * value).sum()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_cubic_passes_unchanged() {
        let kernels = Kernels::new().unwrap();
        let signal: Vec<f64> = (0..60).map(|k| f64::from(k) * 0.1).map(|x| 1.0 + x - 2.0 * x * x + x * x * x).collect();
        let [value, slope, curvature] = kernels.at(&signal, 30, 0.1);
        assert!((value - 13.0).abs() < 1e-9 && (slope - 16.0).abs() < 1e-9 && (curvature - 14.0).abs() < 1e-8);
        assert!((kernels.value(&signal, 30) - value).abs() < 1e-12);
    }
}
