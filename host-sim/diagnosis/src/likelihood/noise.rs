//! The noise that the likelihood whitens with.

use super::belief::StepNoise;

/// Sensor noise, and torque noise of two colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation of a position sample, rad (m).
    pub sensor_sd: f64,
    /// Spectral density of the white torque noise, (N m)^2 s.
    pub torque_density: f64,
    /// Standard deviation of the torque noise that has a memory, N m (N).
    pub colour_sd: f64,
    /// That memory, s.
    pub colour_s: f64,
}

impl Noise {
    /// Over one substep.
    pub(crate) fn over(&self, dt_s: f64) -> StepNoise {
        let kept = (-dt_s / self.colour_s).exp();
        StepNoise {
            torque_variance: self.torque_density / dt_s,
            colour_kept: kept,
            colour_variance: self.colour_sd * self.colour_sd * (1.0 - kept * kept),
        }
    }
}
