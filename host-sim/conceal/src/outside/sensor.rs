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

/// Interpolation error within a period of the scale whose phase runs away as its signals drift: row by row.
pub(super) struct Interpolation {
    amplitude: f64,
    order: f64,
    phase: f64,
    per_row: f64,
    at_start: f64,
}

impl Interpolation {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { amplitude: v[0], order: v[1], phase: v[2], per_row: v[3], at_start: v[2].sin() }
    }
}

impl Hidden for Interpolation {
    fn measured(&mut self, position: f64) -> f64 {
        let error = self.amplitude * ((self.order * position + self.phase).sin() - self.at_start);
        self.phase += self.per_row;
        position + error
    }
}

/// A converter on a clock of its own: what is read grows older by up to so many rows, then jumps back to the present.
pub(super) struct ClockBeat {
    rows: f64,
    per_row: f64,
    beat: f64,
    last: f64,
}

impl ClockBeat {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { rows: v[0], per_row: v[1], beat: 0.0, last: 0.0 }
    }
}

impl Hidden for ClockBeat {
    fn measured(&mut self, position: f64) -> f64 {
        let age = self.rows * self.beat;
        self.beat = (self.beat + self.per_row).fract();
        let read = position - age * (position - self.last);
        self.last = position;
        read
    }
}
