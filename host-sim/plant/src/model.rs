//! The machine as numbers.

use crate::Error;

/// Everything the physics knows of a machine. SI; torques in N m or N, see the crate documentation.
///
/// Build one with [`Model::new`] and struct update syntax; [`Model::validate`] is called by every consumer.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Total moving inertia, kg m2 (kg), above 0.
    pub inertia: f64,
    /// Level of dry friction, N m (N), not negative.
    pub coulomb: f64,
    /// Viscous friction, N m s/rad (N s/m), not negative.
    pub viscous: f64,
    /// Drive torque over commanded torque, 1, above 0.
    pub torque_gain: f64,
    /// Bias the drive adds, N m (N).
    pub torque_offset: f64,
    /// Largest drive torque either way, bias included, N m (N), above 0; none for no limit.
    pub torque_limit: Option<f64>,
    /// From command to acting torque, s, not negative; fractions of a sample are exact.
    pub torque_delay_s: f64,
    /// The electrorheological damper; none for a machine without one.
    pub er: Option<Er>,
}

/// The damper: drag a E^2 + b E of the field that acts, equation (2) of the control specification without its c.
#[derive(Debug, Clone, PartialEq)]
pub struct Er {
    /// N m per (kV/mm)^2, not negative.
    pub a: f64,
    /// N m per kV/mm, not negative.
    pub b: f64,
    /// How the fluid follows the commanded field.
    pub response: FluidResponse,
}

/// How the fluid follows the commanded field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FluidResponse {
    /// The field is delayed; the drag is a E^2 + b E of the delayed field.
    Field(FieldResponse),
    /// The coefficient of viscosity Q = (a E^2 + b E) / max(|w_est|, 0.002) is delayed; the drag is Q_delayed |w|.
    ViscosityDeadTime {
        /// L_Q, s.
        dead_time_s: f64,
        /// Largest drag Q |w| the fluid gives, N m (N); infinite for none.
        torque_limit: f64,
    },
    /// As above with a first-order lag in place of the dead time.
    ViscosityLag {
        /// T_Q, s.
        lag_s: f64,
        /// Largest drag Q |w| the fluid gives, N m (N); infinite for none.
        torque_limit: f64,
    },
}

/// The chain from commanded to acting field: dead time, slew limit, first-order lag. Zeros are instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FieldResponse {
    /// Dead time, s.
    pub dead_time_s: f64,
    /// Largest rate of change of the field, kV/mm/s; none for no limit.
    pub slew_kv_mm_s: Option<f64>,
    /// Time constant while the field rises, s.
    pub rise_s: f64,
    /// Time constant while the field falls, s.
    pub fall_s: f64,
}

impl FieldResponse {
    /// Dead time and one lag for both directions, s.
    pub fn new(dead_time_s: f64, lag_s: f64) -> Self {
        Self { dead_time_s, slew_kv_mm_s: None, rise_s: lag_s, fall_s: lag_s }
    }
}

impl Er {
    /// A damper a E^2 + b E with dead time and lag of the field, s.
    pub fn new(a: f64, b: f64, dead_time_s: f64, lag_s: f64) -> Self {
        Self { a, b, response: FluidResponse::Field(FieldResponse::new(dead_time_s, lag_s)) }
    }
}

impl Model {
    /// A frictionless inertia with a perfect drive, kg m2 (kg).
    pub fn new(inertia: f64) -> Self {
        Self {
            inertia,
            coulomb: 0.0,
            viscous: 0.0,
            torque_gain: 1.0,
            torque_offset: 0.0,
            torque_limit: None,
            torque_delay_s: 0.0,
            er: None,
        }
    }

    /// The servo of the paper: control specification sections 1, 2 and 5, drive delay 5 ms, fluid without delay.
    pub fn paper() -> Self {
        Self {
            coulomb: 0.763,
            torque_limit: Some(30.0),
            torque_delay_s: 0.005,
            er: Some(Er::new(0.0704, 0.470, 0.0, 0.0)),
            ..Self::new(0.075)
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::Parameter`] names the key, the value and what is allowed.
    pub fn validate(&self) -> Result<(), Error> {
        positive("inertia", self.inertia)?;
        not_negative("coulomb", self.coulomb)?;
        not_negative("viscous", self.viscous)?;
        positive("torque_gain", self.torque_gain)?;
        finite("torque_offset", self.torque_offset)?;
        if let Some(limit) = self.torque_limit {
            positive("torque_limit", limit)?;
        }
        not_negative("torque_delay_s", self.torque_delay_s)?;
        self.er.as_ref().map_or(Ok(()), Er::validate)
    }
}

impl Er {
    fn validate(&self) -> Result<(), Error> {
        not_negative("er.a", self.a)?;
        not_negative("er.b", self.b)?;
        match self.response {
            FluidResponse::Field(field) => {
                not_negative("er.dead_time_s", field.dead_time_s)?;
                not_negative("er.rise_s", field.rise_s)?;
                not_negative("er.fall_s", field.fall_s)?;
                field.slew_kv_mm_s.map_or(Ok(()), |slew| positive("er.slew_kv_mm_s", slew))
            }
            FluidResponse::ViscosityDeadTime { dead_time_s: time_s, torque_limit }
            | FluidResponse::ViscosityLag { lag_s: time_s, torque_limit } => {
                not_negative("er.viscosity delay_s", time_s)?;
                check("er.viscosity torque_limit", torque_limit, torque_limit > 0.0, "above 0")
            }
        }
    }
}

/// Refuses anything but a number above zero.
pub(crate) fn positive(key: &str, value: f64) -> Result<(), Error> {
    check(key, value, value.is_finite() && value > 0.0, "a finite number above 0")
}

/// Refuses anything but zero and above.
pub(crate) fn not_negative(key: &str, value: f64) -> Result<(), Error> {
    check(key, value, value.is_finite() && value >= 0.0, "a finite number, 0 or above")
}

/// Refuses what is not a number.
pub(crate) fn finite(key: &str, value: f64) -> Result<(), Error> {
    check(key, value, value.is_finite(), "a finite number")
}

/// Turns a verdict into an error that names the key.
pub(crate) fn check(key: &str, value: f64, holds: bool, allowed: &'static str) -> Result<(), Error> {
    if holds { Ok(()) } else { Err(Error::Parameter { key: key.to_owned(), value, allowed }) }
}
