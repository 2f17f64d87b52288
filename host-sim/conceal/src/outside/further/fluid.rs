//! A damper whose high voltage comes and goes in bursts.

use super::super::{Hidden, Seen};

/// A supply that skips pulses under so little load: it charges the electrodes only when they have fallen below a band, and leaves them to
/// their leak until then (burst mode of converters: Erickson and Maksimovic, Fundamentals of Power Electronics, 2020).
pub(in crate::outside) struct SkippedPulses {
    /// Width of the band over what is wanted, 1.
    share: f64,
    time_s: f64,
    at: f64,
}

impl SkippedPulses {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], time_s: v[1], at: 0.0 }
    }
}

impl Hidden for SkippedPulses {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let [low, high] = [-0.5, 0.5].map(|half| level * (1.0 + half * self.share));
        self.at -= seen.share_of_lag(self.time_s) * self.at;
        if self.at < low {
            // Charged when it was at the low end, within this step: it has leaked since as far as it is below that.
            self.at = high * (self.at / low).max(low / high);
        }
        self.at = self.at.min(high);
        self.at
    }
}

/// A gap that arcs some time after its field went beyond a strength, again and again: each arc takes the charge, which the supply brings back
/// (breakdown limits the field of such clutches: Bullough and others, Proc. Inst. Mech. Eng. I 207 (1993) 87).
pub(in crate::outside) struct Arcs {
    share: f64,
    field_kv_mm: f64,
    charging_s: f64,
    time_s: f64,
    above: bool,
    charged_s: f64,
    lost: f64,
}

impl Arcs {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        let [share, field_kv_mm, charging_s, time_s] = [v[0], v[1], v[2], v[3]];
        Self { share, field_kv_mm, charging_s, time_s, above: false, charged_s: 0.0, lost: 0.0 }
    }
}

impl Hidden for Arcs {
    fn field(&mut self, field_kv_mm: f64) -> f64 {
        self.above = field_kv_mm > self.field_kv_mm;
        field_kv_mm
    }

    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        self.lost -= seen.share_of_lag(self.time_s) * self.lost;
        self.charged_s = if self.above { self.charged_s + seen.step_s } else { 0.0 };
        if self.charged_s >= self.charging_s {
            (self.charged_s, self.lost) = (self.charged_s - self.charging_s, 1.0);
        }
        level * (1.0 - self.share * self.lost)
    }
}
