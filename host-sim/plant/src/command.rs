//! What the plant is told to do.

use crate::Error;

/// One set of commands, held until the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Command {
    /// Commanded motor torque, N m (N on a linear axis).
    pub torque: f64,
    /// Commanded field, kV/mm; a negative field acts as zero.
    pub field_kv_mm: f64,
    /// The field is a constant brake. Only the viscosity models of [`crate::FluidResponse`] look at it: they delay a
    /// braking field as a torque of its own.
    pub braking: bool,
    /// The controller's speed estimate, rad/s (m/s). Only the viscosity models look at it: they recover the
    /// coefficient Q = (a E^2 + b E) / |w| from it.
    pub speed_estimate: f64,
    /// The coefficient Q of the control law's equation (5), N m s/rad (N s/m), where the caller knows it; none to recover
    /// it from field and speed estimate, which loses it at standstill (Q is finite there, the field is zero). Only the
    /// viscosity models look at it, and not while braking.
    pub viscosity: Option<f64>,
    /// Torque from outside on the rotor, N m (N). It passes no drive: no delay, no gain, no limit. Disturbances and
    /// process noise enter here.
    pub external_torque: f64,
}

impl Command {
    /// A motor torque and a field; nothing else.
    pub fn new(torque: f64, field_kv_mm: f64) -> Self {
        Self { torque, field_kv_mm, ..Self::default() }
    }

    /// Refuses what is not a finite number.
    pub(crate) fn check(&self, t_s: f64) -> Result<(), Error> {
        let quantities = [
            ("torque", self.torque),
            ("field", self.field_kv_mm),
            ("speed estimate", self.speed_estimate),
            ("viscosity", self.viscosity.unwrap_or(0.0)),
            ("external torque", self.external_torque),
        ];
        for (quantity, value) in quantities {
            if !value.is_finite() {
                return Err(Error::Command { t_s, quantity, value });
            }
        }
        Ok(())
    }
}
