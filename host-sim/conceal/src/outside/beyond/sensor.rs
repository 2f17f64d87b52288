//! Sensors that feel the torque, that speak now and then, or whose scale is in pieces. They are read once a control period.

use super::super::{Hidden, ramp};
use super::scatter;
use crate::delay::Play;

/// A column that holds the sensor and bends under the torque of the drive, a little late (Slocum, Precision Machine Design, 1992: structural
/// loops); angle per torque, time, period.
pub(in crate::outside) struct ColumnBends {
    per_torque: f64,
    share: f64,
    torque: f64,
    bent: f64,
}

impl ColumnBends {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { per_torque: v[0], share: -(-v[2] / v[1]).exp_m1(), torque: 0.0, bent: 0.0 }
    }
}

impl Hidden for ColumnBends {
    fn feels(&mut self, torque: f64) {
        self.torque = torque;
    }

    fn measured(&mut self, position: f64) -> f64 {
        self.bent += self.share * (self.per_torque * self.torque - self.bent);
        position + self.bent
    }
}

/// A magnetic sensor beside the motor's leads: their current adds to its field, more or less by the angle (Lenz and Edelstein, IEEE Sensors J.
/// 6 (2006) 631: magnetic sensors); angle per torque, order, phase.
pub(in crate::outside) struct StrayField {
    law: [f64; 3],
    torque: f64,
}

impl StrayField {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { law: [v[0], v[1], v[2]], torque: 0.0 }
    }
}

impl Hidden for StrayField {
    fn feels(&mut self, torque: f64) {
        self.torque = torque;
    }

    fn measured(&mut self, position: f64) -> f64 {
        let [per_torque, order, phase] = self.law;
        position + per_torque * self.torque * (order * position + phase).sin()
    }
}

/// A sensor on a bus that speaks only when there is something new: where the position has changed by a step since it last did (Miskowicz,
/// Sensors 6 (2006) 49: send on delta).
pub(in crate::outside) struct OnChange {
    step: f64,
    told: f64,
}

impl OnChange {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { step: v[0], told: 0.0 }
    }
}

impl Hidden for OnChange {
    fn measured(&mut self, position: f64) -> f64 {
        if (position - self.told).abs() >= self.step {
            self.told = position;
        }
        self.told
    }
}

/// A drive that mixes a slow sensor into a fast one, and guesses between the slow one's values: on from the last with the mean speed between
/// the last two (dead reckoning; Franklin, Powell and Workman, Digital Control of Dynamic Systems, 1998: first-order hold).
pub(in crate::outside) struct DeadReckoning {
    share: f64,
    interval_s: f64,
    period_s: f64,
    now_s: f64,
    /// Of the last two values, s and rad or m.
    known: [(f64, f64); 2],
}

impl DeadReckoning {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        let [share, interval_s, period_s] = [v[0], v[1], v[2]];
        Self { share, interval_s, period_s, now_s: 0.0, known: [(-interval_s, 0.0), (0.0, 0.0)] }
    }
}

impl Hidden for DeadReckoning {
    fn measured(&mut self, position: f64) -> f64 {
        // A millionth of a row: times are sums.
        if self.now_s >= self.known[1].0 + self.interval_s - 1e-6 * self.period_s {
            self.known = [self.known[1], (self.now_s, position)];
        }
        let [(before_s, before), (last_s, last)] = self.known;
        let guess = last + (last - before) / (last_s - before_s) * (self.now_s - last_s);
        self.now_s += self.period_s;
        position + self.share * (guess - position)
    }
}

/// A long scale of two pieces that do not meet: beyond the joint all is off by a step, which the head passes over its width (joints of
/// scales in sections, as the makers of linear encoders state them); step, place, width.
pub(in crate::outside) struct Butted(pub(in crate::outside) [f64; 3]);

impl Hidden for Butted {
    fn measured(&mut self, position: f64) -> f64 {
        let [step, at, width] = self.0;
        position + step * (ramp(position - at, width) - ramp(-at, width))
    }
}

/// A scale whose marks are each a little off, with no period in it (Evans and others, CIRP Annals 45 (1996) 617: errors of scales
/// and how they are found);
/// amplitude, pitch, pattern.
pub(in crate::outside) struct MarksOff(pub(in crate::outside) [f64; 3]);

impl MarksOff {
    fn error(&self, position: f64) -> f64 {
        let [amplitude, pitch, pattern] = self.0;
        let marks = position / pitch;
        let [left, right] = [0.0, 1.0].map(|next| scatter(marks.floor() + next, pattern));
        let within = marks - marks.floor();
        amplitude * (2.0 * (left + within * (right - left)) - 1.0)
    }
}

impl Hidden for MarksOff {
    fn measured(&mut self, position: f64) -> f64 {
        position + self.error(position) - self.error(0.0)
    }
}

/// A resolver that turns: voltages that its speed induces beside those of the carrier shift the reading, more or less by the angle (Hanselman,
/// IEEE Trans. Ind. Electron. 37 (1990) 556); time, order, phase, period.
pub(in crate::outside) struct SpeedVoltages {
    rows: f64,
    order: f64,
    phase: f64,
    last: f64,
}

impl SpeedVoltages {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { rows: v[0] / v[3], order: v[1], phase: v[2], last: 0.0 }
    }
}

impl Hidden for SpeedVoltages {
    fn measured(&mut self, position: f64) -> f64 {
        let way = position - self.last;
        self.last = position;
        position + self.rows * way * (self.order * position + self.phase).sin()
    }
}

/// A head in a loose guide, which tilts the other way after each turn: what tilting does to the reading goes with where the marks are
/// (Slocum, as above: Abbe errors at reversals).
pub(in crate::outside) struct TiltingHead {
    amplitude: f64,
    order: f64,
    phase: f64,
    half: f64,
    play: Play,
}

impl TiltingHead {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { amplitude: v[0], order: v[1], phase: v[2], half: v[3], play: Play::new(v[3], 0.0) }
    }
}

impl Hidden for TiltingHead {
    fn measured(&mut self, position: f64) -> f64 {
        let tilt = (position - self.play.pass(position)) / self.half;
        position + self.amplitude * tilt * (self.order * position + self.phase).sin()
    }
}
