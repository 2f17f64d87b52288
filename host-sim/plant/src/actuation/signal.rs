//! A quantity as a formula of time.

/// base + slope dt + amplitude exp(-rate dt), with dt the time since the start of its segment, s.
///
/// Closed under everything between command and rotor: holds, delays, ramps, first-order lags of both.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Signal {
    /// Where the exponential goes, in the unit of the quantity.
    pub base: f64,
    /// Ramp, unit per s.
    pub slope: f64,
    /// What is left to decay at the start.
    pub amplitude: f64,
    /// Inverse time constant, 1/s; 0 where the amplitude is 0.
    pub rate: f64,
}

/// Time constants after which a lag has reached its end to the last bit: exp(-40) = 4e-18.
pub(crate) const SETTLED_TIME_CONSTANTS: f64 = 40.0;

impl Signal {
    /// A value that stays.
    pub fn constant(value: f64) -> Self {
        Self { base: value, ..Self::default() }
    }

    /// Value `dt_s` after the start of the segment.
    #[inline]
    pub fn at(&self, dt_s: f64) -> f64 {
        if dt_s == 0.0 {
            return self.base + self.amplitude;
        }
        let mut value = self.base + self.slope * dt_s;
        if self.amplitude != 0.0 {
            value += self.amplitude * (-self.rate * dt_s).exp();
        }
        value
    }

    /// Mean from `from_s` to `to_s` after the start of the segment; the value where the two are one.
    pub fn mean(&self, from_s: f64, to_s: f64) -> f64 {
        let length_s = to_s - from_s;
        let mut value = self.base + 0.5 * self.slope * (from_s + to_s);
        if self.amplitude != 0.0 {
            let decay = self.rate * length_s;
            let share = if decay > 1e-9 { -(-decay).exp_m1() / decay } else { 1.0 };
            value += self.amplitude * (-self.rate * from_s).exp() * share;
        }
        value
    }

    /// Rate of change `dt_s` after the start of the segment, unit per s.
    #[inline]
    pub(crate) fn rate_at(&self, dt_s: f64) -> f64 {
        if self.amplitude == 0.0 {
            return self.slope;
        }
        self.slope - self.rate * self.amplitude * (-self.rate * dt_s).exp()
    }

    /// First time after the start at which a signal without a ramp passes zero, s.
    pub(crate) fn zero_s(&self) -> Option<f64> {
        let ratio = -self.amplitude / self.base;
        (self.slope == 0.0 && ratio > 1.0 && self.rate > 0.0).then(|| ratio.ln() / self.rate)
    }

    /// The same signal seen from `dt_s` later.
    #[inline]
    pub(crate) fn rebased(&self, dt_s: f64) -> Self {
        let mut signal = *self;
        if dt_s == 0.0 {
            return signal;
        }
        signal.base += self.slope * dt_s;
        if self.amplitude != 0.0 {
            signal.amplitude *= (-self.rate * dt_s).exp();
        }
        signal
    }
}
