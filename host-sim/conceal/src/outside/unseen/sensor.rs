//! Sensors that fall behind the axis. They are read once a control period.

use super::super::Hidden;

/// A converter that tracks the angle with two integrators: right at a constant speed, behind by the acceleration (as converters of resolvers do).
/// By the implicit midpoint rule: stable however fast it is, and no error at a time of 0.
pub(in crate::outside) struct Tracks {
    time_s: f64,
    damping_ratio: f64,
    period_s: f64,
    last: f64,
    at: f64,
    rate: f64,
}

impl Tracks {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { time_s: v[0], damping_ratio: v[1], period_s: v[2], last: 0.0, at: 0.0, rate: 0.0 }
    }
}

impl Hidden for Tracks {
    fn measured(&mut self, position: f64) -> f64 {
        let (time_s, period_s) = (self.time_s, self.period_s);
        let middle = 0.5 * (position + self.last);
        let whole = time_s * time_s + self.damping_ratio * time_s * period_s + 0.25 * period_s * period_s;
        let gains = (middle - self.at - 0.5 * period_s * self.rate) / whole;
        let rate = self.rate + 0.5 * period_s * gains;
        self.at += period_s * (rate + 2.0 * self.damping_ratio * time_s * gains);
        self.rate += period_s * gains;
        self.last = position;
        self.at
    }
}

/// A magnetic scale under a metal cover: eddy currents drag the field behind, most at one speed and less beyond; most, speed, period.
pub(in crate::outside) struct Dragged {
    most: f64,
    way: f64,
    last: f64,
}

impl Dragged {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { most: v[0], way: v[1] * v[2], last: 0.0 }
    }
}

impl Hidden for Dragged {
    fn measured(&mut self, position: f64) -> f64 {
        let ratio = (position - self.last) / self.way;
        self.last = position;
        position - 2.0 * self.most * ratio / (1.0 + ratio * ratio)
    }
}
