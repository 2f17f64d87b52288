//! Where the machine is.

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

/// State of the mechanics.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// Rotor position, rad (m).
    pub position: f64,
    /// Rotor speed, rad/s (m/s).
    pub velocity: f64,
    /// Sliding direction; decides the sign of the drag while the speed passes through zero.
    pub(crate) motion: Motion,
    /// Which side of its kinks the law of motion is on, see `Flow::regime`.
    pub(crate) regime: u8,
}

impl State {
    /// At a position, rad (m), with a speed, rad/s (m/s).
    pub fn new(position: f64, velocity: f64) -> Self {
        Self { position, velocity, motion: Motion::along(velocity), ..Self::default() }
    }

    /// Sliding direction.
    pub fn motion(&self) -> Motion {
        self.motion
    }
}
