//! Torques from outside: pulses (`disturbance_pulse`) and a steady sine (`vibration`).

use std::f64::consts::TAU;

use crate::Error;
use crate::model::{finite, not_negative};

/// A push from outside, N m (N), from `start_s` for `duration_s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pulse {
    /// Start, s.
    pub start_s: f64,
    /// Length, s, not negative.
    pub duration_s: f64,
    /// Torque, N m (N).
    pub amplitude: f64,
}

impl Pulse {
    pub(crate) fn validate(&self) -> Result<(), Error> {
        finite("disturbance_pulse.start_s", self.start_s)?;
        not_negative("disturbance_pulse.duration_s", self.duration_s)?;
        finite("disturbance_pulse.amplitude", self.amplitude)
    }

    /// End, s.
    pub(crate) fn end_s(&self) -> f64 {
        self.start_s + self.duration_s
    }
}

/// amplitude sin(2 pi frequency t + phase), t the absolute time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vibration {
    /// Frequency, Hz, not negative.
    pub frequency_hz: f64,
    /// Torque, N m (N).
    pub amplitude: f64,
    /// Phase at t = 0, rad.
    pub phase_rad: f64,
}

impl Vibration {
    pub(crate) fn validate(&self) -> Result<(), Error> {
        not_negative("vibration.frequency_hz", self.frequency_hz)?;
        finite("vibration.amplitude", self.amplitude)?;
        finite("vibration.phase_rad", self.phase_rad)
    }

    /// Torque at an absolute time, N m (N).
    #[inline]
    pub fn torque(&self, t_s: f64) -> f64 {
        self.amplitude * (TAU * self.frequency_hz * t_s + self.phase_rad).sin()
    }
}
