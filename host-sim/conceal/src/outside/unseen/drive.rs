//! Torques that the drive shapes before they act.

use std::f64::consts::TAU;

use super::super::{Hidden, Seen};

/// A response of second order by the implicit midpoint rule: stable however fast it is, and none at a time of 0.
pub(in crate::outside) struct Swing {
    /// One over the angular frequency, s.
    time_s: f64,
    damping_ratio: f64,
    at: f64,
    rate: f64,
}

impl Swing {
    pub(in crate::outside) fn new(time_s: f64, damping_ratio: f64) -> Self {
        Self { time_s, damping_ratio, at: 0.0, rate: 0.0 }
    }

    /// Value and rate in the middle of a step under an input.
    pub(in crate::outside) fn pass(&mut self, input: f64, step_s: f64) -> [f64; 2] {
        let squared = self.time_s * self.time_s;
        let whole = squared + self.damping_ratio * self.time_s * step_s + 0.25 * step_s * step_s;
        let rate = (squared * self.rate + 0.5 * step_s * (input - self.at)) / whole;
        let middle = self.at + 0.5 * step_s * rate;
        self.at += step_s * rate;
        self.rate = 2.0 * rate - self.rate;
        [middle, rate]
    }
}

/// A notch that was set for a resonance of another machine: 1 - share 2 d t s / (t^2 s^2 + 2 d t s + 1).
pub(in crate::outside) struct Notch {
    share: f64,
    band: Swing,
}

impl Notch {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], band: Swing::new(1.0 / (TAU * v[1]), v[2]) }
    }
}

impl Hidden for Notch {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let [_, rate] = self.band.pass(torque, seen.step_s);
        torque - self.share * 2.0 * self.band.damping_ratio * self.band.time_s * rate
    }
}

/// A current controller with too much integral: the torque overshoots each change and rings.
pub(in crate::outside) struct Rings(Swing);

impl Rings {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self(Swing::new(v[0], v[1]))
    }
}

impl Hidden for Rings {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        self.0.pass(torque, seen.step_s)[0]
    }
}

/// A supply with a ripple of its own frequency that no controller of the current takes out; share, Hz, phase.
pub(in crate::outside) struct SupplyPulses(pub(in crate::outside) [f64; 3]);

impl Hidden for SupplyPulses {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        torque * (1.0 + self.0[0] * wave(&self.0, seen))
    }
}

/// Sine over the time, in the middle of a step, of a law whose second value is Hz and whose third is a phase.
pub(super) fn wave(values: &[f64; 3], seen: &Seen) -> f64 {
    (TAU * values[1] * (seen.t_s + 0.5 * seen.step_s) + values[2]).sin()
}
