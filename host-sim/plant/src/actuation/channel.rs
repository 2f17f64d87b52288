//! One path from command to acting quantity: dead time, slew limit, first-order lag.

use std::collections::VecDeque;

use super::signal::{SETTLED_TIME_CONSTANTS, Signal};
use crate::er_fluid::Kinetics;

/// Shortest time that counts, s: changes closer than this happen together. It absorbs the rounding of delays that are
/// whole numbers of samples, and grows with the times so that recordings with large time stamps work too.
#[inline]
pub(crate) fn coincidence_s(t_s: f64) -> f64 {
    (4.0 * f64::EPSILON * t_s.abs()).max(1e-12)
}

/// Dead time, then slew limit, then lag. Its formulas count time from the start of the current segment.
#[derive(Debug, Clone)]
pub(crate) struct Channel {
    dead_time_s: f64,
    /// Commands under way: time they act, value.
    pending: VecDeque<(f64, f64)>,
    /// The last value pushed, so that a held command is no change.
    last: f64,
    /// Unit per s; infinite for none.
    slew: f64,
    rise_s: f64,
    fall_s: f64,
    /// How the two depend on the value.
    kinetics: Kinetics,
    /// Where the fall began that goes on; none while it does not fall.
    fell_from: Option<f64>,
    /// Where the slew limiter goes.
    target: f64,
    /// Where it is.
    ramp: f64,
    output: Signal,
    /// Time from the start of the segment until the formula of `output` ends, s.
    valid_s: f64,
}

impl Channel {
    /// A channel at rest at `value`.
    pub(crate) fn new(value: f64, dead_time_s: f64, slew: f64, rise_s: f64, fall_s: f64) -> Self {
        Self {
            dead_time_s,
            pending: VecDeque::new(),
            last: value,
            slew,
            rise_s,
            fall_s,
            kinetics: Kinetics::default(),
            fell_from: None,
            target: value,
            ramp: value,
            output: Signal::constant(value),
            valid_s: f64::INFINITY,
        }
    }

    /// The same with lags that depend on the value.
    pub(crate) fn over_the_field(self, kinetics: Kinetics) -> Self {
        Self { kinetics, ..self }
    }

    /// A channel with dead time and one lag.
    pub(crate) fn lagging(value: f64, dead_time_s: f64, lag_s: f64) -> Self {
        Self::new(value, dead_time_s, f64::INFINITY, lag_s, lag_s)
    }

    /// Takes the command given at `t_s`.
    #[inline]
    pub(crate) fn push(&mut self, t_s: f64, value: f64) {
        if value != self.last {
            self.pending.push_back((t_s + self.dead_time_s, value));
            self.last = value;
        }
    }

    /// Lets everything due at `t_s` act; the formulas must already count from `t_s`.
    #[inline]
    pub(crate) fn update(&mut self, t_s: f64, coincidence_s: f64) {
        let mut changed = self.valid_s <= coincidence_s;
        while let Some(&(due_s, value)) = self.pending.front() {
            if due_s > t_s + coincidence_s {
                break;
            }
            self.pending.pop_front();
            self.target = value;
            changed = true;
        }
        if changed {
            self.retarget(coincidence_s);
        }
    }

    /// Rewrites the formula after a change of target, at the end of a ramp or where the lag changes direction.
    fn retarget(&mut self, coincidence_s: f64) {
        let value = self.output.at(0.0);
        let mut remaining_s = (self.target - self.ramp).abs() / self.slew;
        let mut slope = self.slew.copysign(self.target - self.ramp);
        if remaining_s <= coincidence_s {
            (self.ramp, slope, remaining_s) = (self.target, 0.0, f64::INFINITY);
        }
        let mut ahead = self.ramp - value;
        if ahead.abs() <= slope.abs() * coincidence_s {
            ahead = 0.0;
        }
        let lag_s = self.lag_s(ahead, slope, value);
        self.valid_s = remaining_s;
        if lag_s <= 0.0 {
            self.output = Signal { base: self.ramp, slope, amplitude: 0.0, rate: 0.0 };
            return;
        }
        // A lag follows a ramp of slope k at a distance of k tau, after an exponential.
        let distance = slope * lag_s;
        let amplitude = distance - ahead;
        self.output = Signal { base: self.ramp - distance, slope, amplitude, rate: lag_s.recip() };
        if ahead * slope < 0.0 {
            self.valid_s = self.valid_s.min(lag_s * (-ahead / distance).ln_1p());
        }
        self.valid_s = self.valid_s.min(SETTLED_TIME_CONSTANTS * lag_s);
        if amplitude.abs() <= f64::EPSILON * self.ramp.abs().max(value.abs()) {
            self.output.amplitude = 0.0;
            self.output.rate = 0.0;
            self.valid_s = remaining_s;
        }
    }

    /// Time constant from `value` on towards what is `ahead` and moves by `slope`, s; a fall keeps the one of where it began.
    #[inline]
    fn lag_s(&mut self, ahead: f64, slope: f64, value: f64) -> f64 {
        if ahead > 0.0 || (ahead == 0.0 && slope > 0.0) {
            self.fell_from = None;
            return Kinetics::time_constant_s(self.rise_s, self.kinetics.rise_exponent, self.target);
        }
        if ahead == 0.0 && slope == 0.0 {
            // Settled: the next fall begins here.
            self.fell_from = None;
            return self.fall_s;
        }
        let from = *self.fell_from.get_or_insert(value);
        Kinetics::time_constant_s(self.fall_s, self.kinetics.fall_exponent, from)
    }

    /// The formula from the start of the current segment.
    #[inline]
    pub(crate) fn output(&self) -> Signal {
        self.output
    }

    /// The next time this channel changes its formula, s; `t_s` is the start of the segment.
    #[inline]
    pub(crate) fn next_change_s(&self, t_s: f64) -> f64 {
        let due_s = self.pending.front().map_or(f64::INFINITY, |&(due_s, _)| due_s);
        due_s.min(t_s + self.valid_s)
    }

    /// Moves the start of the formulas to the end of a segment `dt_s` long.
    #[inline]
    pub(crate) fn rebase(&mut self, dt_s: f64) {
        self.output = self.output.rebased(dt_s);
        self.ramp += self.output.slope * dt_s;
        self.valid_s -= dt_s;
    }
}
