//! Savitzky-Golay filter (A. Savitzky, M. J. E. Golay, 1964): a cubic fitted to each stretch of samples.

use nalgebra::{Matrix4, Vector4};

/// Samples to either side: 41 samples are 20 ms at 2 kHz.
pub(super) const HALF: usize = 20;

/// Kernels of value, slope and curvature for samples a unit apart, and what the one of the curvature is to a torque.
#[derive(Debug, Clone)]
pub(super) struct Kernels {
    motion: [Vec<f64>; 3],
    torque: Vec<f64>,
}

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
        let curvature = kernel(2, 2.0 / (half * half));
        let torque = summed_twice(&curvature);
        Some(Self { motion: [kernel(0, 1.0), kernel(1, 1.0 / half), curvature], torque })
    }

    /// Value, slope and curvature of the signal around sample `at`, for samples `period` apart.
    pub(super) fn at(&self, signal: &[f64], at: usize, period: f64) -> [f64; 3] {
        let [value, slope, curvature] = self.motion.each_ref().map(|kernel| weighed(kernel, signal, at));
        [value, slope / period, curvature / (period * period)]
    }

    /// A torque around sample `at` as the curvature of the position shows it: with the pass band of a value a torque would
    /// differ from the acceleration it causes, and every recording would read as one of a wrong gain.
    pub(super) fn torque(&self, signal: &[f64], at: usize) -> f64 {
        weighed(&self.torque, signal, at)
    }
}

fn weighed(kernel: &[f64], signal: &[f64], at: usize) -> f64 {
    kernel.iter().zip(&signal[at - HALF..=at + HALF]).map(|(weight, value)| weight * value).sum()
}

/// The kernel that gives from a second difference what `kernel` gives from the signal itself.
fn summed_twice(kernel: &[f64]) -> Vec<f64> {
    let sum = |of: Vec<f64>| -> Vec<f64> {
        let running = of.iter().scan(0.0, |sum, weight| {
            *sum += weight;
            Some(*sum)
        });
        running.collect()
    };
    // The sum of two passes stands one sample ahead of the difference about a sample.
    let mut summed = vec![0.0];
    summed.extend(sum(sum(kernel.to_vec())));
    summed.pop();
    summed
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
    }

    #[test]
    fn a_torque_passes_as_the_acceleration_it_causes() {
        let kernels = Kernels::new().unwrap();
        let torque: Vec<f64> = (0..80).map(|k| (0.3 * f64::from(k)).sin() + f64::from(k / 37)).collect();
        let (mut position, mut speed) = (vec![0.0], 0.0);
        for drive in &torque[1..] {
            position.push(position[position.len() - 1] + speed);
            speed += drive;
        }
        // The second difference about sample k of this position is the torque of sample k.
        let shown = kernels.at(&position, 40, 1.0)[2];
        assert!((shown - kernels.torque(&torque, 40)).abs() < 1e-9);
        assert!((kernels.torque(&[1.0; 60], 30) - 1.0).abs() < 1e-9);
    }
}
