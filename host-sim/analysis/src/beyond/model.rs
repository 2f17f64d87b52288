//! The machine as the modes know it: one rotor with dry friction, a motor that answers late, a field that waits and lags.

use std::collections::VecDeque;

use er_servo::Config;

use crate::paper::case::{A, B, COULOMB_NM, DELAY_S, INERTIA_KG_M2};
use crate::simulate;

/// Dead time and lag of the field that the modes are told, s.
pub(super) const DEAD_TIME_S: f64 = 0.002;
pub(super) const LAG_S: f64 = 0.003;
/// Bandwidth of the observer, rad/s: five times that of the loop, a twentieth of the sampling frequency.
const OBSERVER_RAD_S: f64 = 300.0;
/// Bandwidth of its estimate of a torque from outside, rad/s: that of the loop, so that a push of 50 ms is known within a
/// fifth of it.
const DISTURBANCE_RAD_S: f64 = 200.0;
/// Torques from outside below this are the friction's own error, N m: a quarter of its level.
const DISTURBANCE_NM: f64 = 0.2;
/// A rotor at rest in the model moves when the sensor says so by more than this, rad: two counts.
const MOVED_RAD: f64 = 2.0 * er_servo::RAD_PER_COUNT as f64;

/// Position, rad, and speed, rad/s.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Motion {
    pub(super) position: f64,
    pub(super) speed: f64,
}

impl Motion {
    /// One period on under a torque and a drag, N m; friction holds, it does not reverse.
    fn after(self, torque_nm: f64, drag_nm: f64, period_s: f64) -> Self {
        let direction = if self.speed == 0.0 { torque_nm.signum() } else { self.speed.signum() };
        if self.speed == 0.0 && torque_nm.abs() <= drag_nm {
            return self;
        }
        let speed = self.speed + period_s / INERTIA_KG_M2 * (torque_nm - direction * drag_nm);
        let speed = if speed * direction < 0.0 { 0.0 } else { speed };
        Self { position: self.position + 0.5 * period_s * (self.speed + speed), speed }
    }
}

/// a E^2 + b E, N m.
pub(super) fn torque_nm(field_kv_mm: f64) -> f64 {
    (A * field_kv_mm + B) * field_kv_mm
}

/// The field of that torque, kV/mm.
pub(super) fn field_kv_mm(torque_nm: f64) -> f64 {
    simulate::field_kv_mm((A, B), torque_nm.max(0.0))
}

/// What will happen: the state when a field commanded now begins to act, with the field that acts then, and the state when
/// a torque commanded now does.
pub(super) struct Ahead {
    pub(super) at_field: Motion,
    pub(super) acting_kv_mm: f64,
    pub(super) at_torque: Motion,
}

/// Observer of the rotor, with everything that was commanded and does not act yet.
#[derive(Debug)]
pub(super) struct Observer {
    period_s: f64,
    motion: Motion,
    /// Torque from outside, as far as known, N m.
    disturbance: f64,
    /// Acting field, kV/mm.
    field: f64,
    /// Under way, oldest first, N m and kV/mm.
    torques: VecDeque<f64>,
    fields: VecDeque<f64>,
}

impl Observer {
    pub(super) fn new(config: &Config) -> Self {
        let period_s = f64::from(config.period_s);
        let ticks = |delay_s: f64| (delay_s / period_s).round() as usize;
        Self {
            period_s,
            motion: Motion::default(),
            disturbance: 0.0,
            field: 0.0,
            torques: VecDeque::from(vec![0.0; ticks(DELAY_S)]),
            fields: VecDeque::from(vec![0.0; ticks(DEAD_TIME_S)]),
        }
    }

    /// Takes a measured position, rad.
    pub(super) fn correct(&mut self, position: f64) -> Motion {
        let keep = (-OBSERVER_RAD_S * self.period_s).exp();
        let off = position - self.motion.position;
        if self.motion.speed == 0.0 && off.abs() <= MOVED_RAD {
            self.disturbance *= 1.0 - DISTURBANCE_RAD_S * self.period_s;
            return self.motion;
        }
        self.motion.position += (1.0 - keep * keep) * off;
        let jump = (1.0 - keep).powi(2) / self.period_s * off;
        self.motion.speed += jump;
        // The speed that the model did not foresee is a torque it does not know.
        let share = DISTURBANCE_RAD_S * self.period_s;
        self.disturbance += share * INERTIA_KG_M2 * jump / self.period_s;
        self.motion
    }

    fn keep(&self) -> f64 {
        (-self.period_s / LAG_S).exp()
    }

    /// Torque from outside that the model acts on, N m.
    pub(super) fn outside(&self) -> f64 {
        (self.disturbance.abs() - DISTURBANCE_NM).max(0.0).copysign(self.disturbance)
    }

    pub(super) fn ahead(&self) -> Ahead {
        let (mut motion, mut field) = (self.motion, self.field);
        let mut at_field = (motion, field);
        let held = self.fields.back().copied().unwrap_or(0.0);
        for (tick, torque) in self.torques.iter().enumerate() {
            if tick == self.fields.len() {
                at_field = (motion, field);
            }
            let target = self.fields.get(tick).copied().unwrap_or(held);
            motion = motion.after(*torque + self.outside(), COULOMB_NM + torque_nm(field), self.period_s);
            field = target + (field - target) * self.keep();
        }
        Ahead { at_field: at_field.0, acting_kv_mm: at_field.1, at_torque: motion }
    }

    /// Takes what is commanded in this period and goes to the end of it.
    pub(super) fn command(&mut self, torque: f64, field_kv_mm: f64) {
        self.torques.push_back(torque);
        self.fields.push_back(field_kv_mm);
        let acting_nm = self.torques.pop_front().unwrap_or(0.0);
        let target = self.fields.pop_front().unwrap_or(0.0);
        self.motion = self.motion.after(acting_nm + self.outside(), COULOMB_NM + torque_nm(self.field), self.period_s);
        self.field = target + (self.field - target) * self.keep();
    }
}
