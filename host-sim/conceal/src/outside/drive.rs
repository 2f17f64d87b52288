//! Torques that are not what was commanded.

use super::{Heat, Hidden, Seen};

/// Gain that ripples over the angle.
pub(super) struct Ripple(pub(super) [f64; 3]);

impl Hidden for Ripple {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let [share, order, phase] = self.0;
        torque * (1.0 + share * (order * seen.position + phase).sin())
    }
}

/// Torque that dips where one winding hands over to the next.
pub(super) struct Dips(pub(super) [f64; 3]);

impl Hidden for Dips {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let [share, order, phase] = self.0;
        torque * (1.0 - share * (0.5 * (order * seen.position + phase)).sin().powi(8))
    }
}

/// A share of the torque that comes late and goes late.
pub(super) struct Creep {
    share: f64,
    time_s: f64,
    late: f64,
}

impl Creep {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { share: v[0], time_s: v[1], late: 0.0 }
    }
}

impl Hidden for Creep {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        self.late += seen.share_of_lag(self.time_s) * (torque - self.late);
        torque + self.share * (self.late - torque)
    }
}

/// Another gain one way than the other.
pub(super) struct GainBySign(pub(super) f64);

impl Hidden for GainBySign {
    fn drive(&mut self, _: &Seen, torque: f64) -> f64 {
        torque + 0.5 * self.0 * torque.abs()
    }
}

/// Gain that fades as the windings warm.
pub(super) struct Fades {
    share: f64,
    heat: Heat,
}

impl Fades {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { share: v[0], heat: Heat::new(v[1], v[2]) }
    }
}

impl Hidden for Fades {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        torque * (1.0 - self.share * self.heat.after(torque * torque, seen.step_s))
    }
}

/// A supply that sags under mechanical power.
pub(super) struct Sag(pub(super) [f64; 2]);

impl Hidden for Sag {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let [share, power] = self.0;
        let drawn = (torque * seen.speed).max(0.0) / power;
        torque * (1.0 - share * drawn / (1.0 + drawn))
    }
}

/// A supply whose voltage the turning motor uses up: what is left limits the torque that drives, not the one that brakes. The limit is
/// the torque over the share at rest, and falls by the torque until the speed.
pub(super) struct BackEmf(pub(super) [f64; 3]);

impl Hidden for BackEmf {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let [share, speed, most] = self.0;
        if torque * seen.speed <= 0.0 {
            return torque;
        }
        let headroom = most * (1.0 / share - seen.speed.abs() / speed).max(0.0);
        torque.clamp(-headroom, headroom)
    }
}

/// A current controller that knows only whole steps, none of them at zero.
pub(super) struct Steps(pub(super) [f64; 2]);

impl Hidden for Steps {
    fn drive(&mut self, _: &Seen, torque: f64) -> f64 {
        let [step, offset] = self.0;
        ((torque / step + offset).round() - offset) * step
    }
}

/// Torque that can only change so fast: inductance and a limited voltage.
pub(super) struct Slew {
    per_s: f64,
    torque: f64,
}

impl Slew {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { per_s: v[0], torque: 0.0 }
    }
}

impl Hidden for Slew {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let most = self.per_s * seen.step_s;
        self.torque += (torque - self.torque).clamp(-most, most);
        self.torque
    }
}
