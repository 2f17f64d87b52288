//! Sensors whose scale is not straight.

use super::Hidden;
use crate::delay::Play;

/// Scale that changes over the range.
pub(super) struct Bent(pub(super) f64);

impl Hidden for Bent {
    fn measured(&mut self, position: f64) -> f64 {
        position + self.0 * position * position
    }
}

/// A coupling of the sensor with play.
pub(super) struct LooseSensor(Play);

impl LooseSensor {
    pub(super) fn new(v: &[f64]) -> Self {
        Self(Play::new(v[0], 0.0))
    }
}

impl Hidden for LooseSensor {
    fn measured(&mut self, position: f64) -> f64 {
        self.0.pass(position)
    }
}

/// Interpolation that runs off within each period and jumps back; amplitude, periods, offset.
pub(super) struct Sawtooth(pub(super) [f64; 3]);

impl Hidden for Sawtooth {
    fn measured(&mut self, position: f64) -> f64 {
        let [amplitude, order, offset] = self.0;
        let within = |at: f64| (order * at / std::f64::consts::TAU + offset).rem_euclid(1.0);
        position + 2.0 * amplitude * (within(position) - within(0.0))
    }
}
