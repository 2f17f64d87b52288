//! A damper whose drag is not a law of the field alone.

use super::{Hidden, Seen};
use crate::delay::Play;

/// Particles that keep some of the field.
pub(super) struct Remanence(Play);

impl Remanence {
    pub(super) fn new(v: &[f64]) -> Self {
        Self(Play::new(v[0], 0.0))
    }
}

impl Hidden for Remanence {
    fn field(&mut self, field_kv_mm: f64) -> f64 {
        self.0.pass(field_kv_mm).max(0.0)
    }
}

/// A structure that builds up while the axis is slow.
pub(super) struct Sets {
    share: f64,
    time_s: f64,
    speed: f64,
    built: f64,
}

impl Sets {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { share: v[0], time_s: v[1], speed: v[2], built: 0.0 }
    }
}

impl Hidden for Sets {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let wanted = 1.0 / (1.0 + (seen.speed / self.speed).powi(2));
        self.built += seen.share_of_lag(self.time_s) * (wanted - self.built);
        level * (1.0 + self.share * self.built)
    }
}

/// A gap that is not the same all around.
pub(super) struct EccentricGap(pub(super) [f64; 3]);

impl Hidden for EccentricGap {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let [share, order, phase] = self.0;
        level * (1.0 + share * (order * seen.position + phase).sin())
    }
}

/// Drag that thins with the shear.
pub(super) struct Thins(pub(super) [f64; 2]);

impl Hidden for Thins {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let [share, speed] = self.0;
        level * (1.0 - share * seen.speed.abs() / (seen.speed.abs() + speed))
    }
}

/// A field that saturates: s tanh(E/s).
pub(super) struct Saturates(pub(super) f64);

impl Hidden for Saturates {
    fn field(&mut self, field_kv_mm: f64) -> f64 {
        self.0 * (field_kv_mm / self.0).tanh()
    }
}

/// Vanes or grooves that hold the fluid's chains better one way than the other.
pub(super) struct OneWay(pub(super) f64);

impl Hidden for OneWay {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let direction = if seen.speed == 0.0 { 0.0 } else { seen.speed.signum() };
        level * (1.0 + 0.5 * self.0 * direction)
    }
}

/// Chains that stand upright again at each turn and resist more until the shear has bent them: the overshoot of stress at the start of
/// a shear.
pub(super) struct Overshoot {
    share: f64,
    way: f64,
    travelled: f64,
    last: f64,
}

impl Overshoot {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { share: v[0], way: v[1], travelled: 0.0, last: 0.0 }
    }
}

impl Hidden for Overshoot {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        if seen.speed * self.last < 0.0 {
            self.travelled = 0.0;
        }
        self.last = if seen.speed == 0.0 { self.last } else { seen.speed };
        self.travelled += seen.step_s * seen.speed.abs();
        level * (1.0 + self.share * (-self.travelled / self.way).exp())
    }
}
