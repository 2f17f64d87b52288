//! Sensors that smooth what they read, and sensors that put themselves right again. They are read once a control period.

use super::super::Hidden;

/// A sensor that smooths the more the slower it moves, to look quiet at rest (Casiez, Roussel and Vogel, Proc. CHI 2012, 2527: the one-euro
/// filter); time at rest, speed that halves it, period.
pub(in crate::outside) struct AdaptiveSmoothing {
    rows: f64,
    way: f64,
    last: f64,
    at: f64,
}

impl AdaptiveSmoothing {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { rows: v[0] / v[2], way: v[1] * v[2], last: 0.0, at: 0.0 }
    }
}

impl Hidden for AdaptiveSmoothing {
    fn measured(&mut self, position: f64) -> f64 {
        let ratio = (position - self.last) / self.way;
        self.last = position;
        self.at += (position - self.at) / (1.0 + self.rows / (1.0 + ratio * ratio));
        self.at
    }
}

/// A sensor that takes every change that is too fast for a fault, and lets its reading follow at most at one rate (Horowitz and Hill, The Art
/// of Electronics, 2015: limits of slew); share, speed, period.
pub(in crate::outside) struct SlewedReading {
    share: f64,
    most: f64,
    at: f64,
}

impl SlewedReading {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], most: v[1] * v[2], at: 0.0 }
    }
}

impl Hidden for SlewedReading {
    fn measured(&mut self, position: f64) -> f64 {
        self.at += (position - self.at).clamp(-self.most, self.most);
        position + self.share * (self.at - position)
    }
}

/// A counter that noise at the flanks makes count up, whichever way it goes, until the index mark puts it right (Ellis, Control System Design
/// Guide, 2012: encoders with an index); share of the way, place of the mark.
pub(in crate::outside) struct IndexResets {
    share: f64,
    mark: f64,
    last: f64,
    error: f64,
}

impl IndexResets {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], mark: v[1], last: 0.0, error: 0.0 }
    }
}

impl Hidden for IndexResets {
    fn measured(&mut self, position: f64) -> f64 {
        self.error += self.share * (position - self.last).abs();
        if (position - self.mark) * (self.last - self.mark) < 0.0 {
            // What came since the mark.
            self.error = self.share * (position - self.mark).abs();
        }
        self.last = position;
        position + self.error
    }
}

/// An angle from a gyroscope: its bias runs away with it while the axis moves, and is taken out where the axis rests (Foxlin, IEEE Comput.
/// Graph. Appl. 25 (2005) 38: updates at no speed); bias, speed of rest, time of taking out, period.
pub(in crate::outside) struct RestUpdates {
    per_row: f64,
    way: f64,
    share: f64,
    last: f64,
    error: f64,
}

impl RestUpdates {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        let [bias, speed, time_s, period_s] = [v[0], v[1], v[2], v[3]];
        let share = -(-period_s / time_s).exp_m1();
        Self { per_row: bias * period_s, way: speed * period_s, share, last: 0.0, error: 0.0 }
    }
}

impl Hidden for RestUpdates {
    fn measured(&mut self, position: f64) -> f64 {
        let rests = (position - self.last).abs() < self.way;
        self.last = position;
        self.error += if rests { -self.share * self.error } else { self.per_row };
        position + self.error
    }
}
