//! Where the machine is.

use super::fluid::FluidRegime;
use crate::effects::shaft::Contact;

/// Which way the rotor slides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Motion {
    /// Held by the drag; speed is exactly zero.
    #[default]
    Stuck,
    /// Sliding, or just about to, towards larger positions.
    Forward,
    /// Sliding, or just about to, towards smaller positions.
    Backward,
}

impl Motion {
    /// +1, -1 or 0.
    #[inline]
    pub fn sign(self) -> f64 {
        match self {
            Motion::Stuck => 0.0,
            Motion::Forward => 1.0,
            Motion::Backward => -1.0,
        }
    }

    /// The motion a speed, or an unbalanced torque, leads to.
    #[inline]
    pub(crate) fn along(value: f64) -> Self {
        if value > 0.0 {
            Motion::Forward
        } else if value < 0.0 {
            Motion::Backward
        } else {
            Motion::Stuck
        }
    }
}

/// State of the mechanics. The nominal machine has a position and a speed only; the rest belongs to effects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Rotor position, rad (m).
    pub position: f64,
    /// Rotor speed, rad/s (m/s).
    pub velocity: f64,
    /// Load minus motor position behind a flexible shaft, rad (m).
    pub twist: f64,
    /// Its rate, rad/s (m/s).
    pub twist_rate: f64,
    /// Torque of the dry-friction bristle, N m (N), signed like the motion it opposes.
    pub bristle_torque: f64,
    /// Torque of the fluid's spring below yield, N m (N), signed likewise.
    pub spring_torque: f64,
    /// Heat above the start that warms the viscous friction, J.
    pub friction_heat_j: f64,
    /// Heat above the start that warms the damper's fluid, J.
    pub fluid_heat_j: f64,
    /// Sliding direction; decides the sign of the drag while the speed passes through zero.
    pub(crate) motion: Motion,
    pub(crate) fluid_regime: FluidRegime,
    pub(crate) contact: Contact,
}

impl State {
    /// At a position, rad (m), with a speed, rad/s (m/s); load in the middle of its gap and moving along, bristles
    /// unloaded, everything cold.
    pub fn new(position: f64, velocity: f64) -> Self {
        Self {
            position,
            velocity,
            twist: 0.0,
            twist_rate: 0.0,
            bristle_torque: 0.0,
            spring_torque: 0.0,
            friction_heat_j: 0.0,
            fluid_heat_j: 0.0,
            motion: Motion::along(velocity),
            fluid_regime: FluidRegime::Free,
            contact: Contact::Always,
        }
    }

    /// With the sliding direction of its speed, whoever wrote that.
    pub(crate) fn with_motion(mut self) -> Self {
        if self.velocity != 0.0 {
            self.motion = Motion::along(self.velocity);
        }
        self
    }

    /// Sliding direction.
    pub fn motion(&self) -> Motion {
        self.motion
    }
}

impl Default for State {
    /// At rest at zero.
    fn default() -> Self {
        Self::new(0.0, 0.0)
    }
}
