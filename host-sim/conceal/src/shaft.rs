//! The load behind a flexible shaft, with or without a gap.

use std::f64::consts::TAU;

use crate::physics;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Shaft {
    pub(crate) motor_share: f64,
    load_share: f64,
    stiffness_per_inertia: f64,
    damping_per_inertia: f64,
    half_gap_rad: f64,
    position_rad: f64,
    speed_rad_s: f64,
}

impl Shaft {
    pub(crate) fn new(law: &physics::Shaft) -> Self {
        let motor_share = 1.0 / (1.0 + law.inertia_ratio);
        let load_share = 1.0 - motor_share;
        let reduced = motor_share * load_share;
        let omega = TAU * law.resonance_hz;
        Self {
            motor_share,
            load_share,
            stiffness_per_inertia: reduced * omega * omega,
            damping_per_inertia: 2.0 * law.damping_ratio * omega * reduced,
            half_gap_rad: 0.5 * law.gap_rad,
            position_rad: 0.0,
            speed_rad_s: 0.0,
        }
    }

    /// Torque on the motor in the middle of a step, N m, and the load moved on by that step.
    pub(crate) fn pass(&mut self, motor_rad: f64, motor_rad_s: f64, inertia: f64, step_s: f64) -> f64 {
        let middle = self.position_rad + 0.5 * step_s * self.speed_rad_s;
        let twist = motor_rad - middle;
        let spring = twist - twist.clamp(-self.half_gap_rad, self.half_gap_rad);
        let touching = spring != 0.0 || self.half_gap_rad == 0.0;
        let damping = if touching { self.damping_per_inertia * (motor_rad_s - self.speed_rad_s) } else { 0.0 };
        let mut torque = inertia * (self.stiffness_per_inertia * spring + damping);
        if self.half_gap_rad > 0.0 {
            // Teeth push, they do not pull.
            torque = if spring > 0.0 { torque.max(0.0) } else { torque.min(0.0) };
        }
        let next = self.speed_rad_s + step_s * torque / (inertia * self.load_share);
        self.position_rad = middle + 0.5 * step_s * next;
        self.speed_rad_s = next;
        -torque
    }
}
