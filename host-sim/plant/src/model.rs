//! The machine as numbers.

use crate::effects::{Asymmetry, Gravity, Harmonic, Pulse, Shaft, Stribeck, Vibration, Warming, friction, position};
use crate::er_fluid::{FlowCurve, Kinetics};
use crate::{Error, sensor::SensorModel};

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
    /// Commands smaller than this give nothing, larger ones act less by this much, N m (N), not negative.
    pub torque_deadband: f64,
    /// From command to acting torque, s, not negative; fractions of a sample are exact.
    pub torque_delay_s: f64,
    /// First-order lag of the torque behind that delay, s, not negative.
    pub torque_lag_s: f64,
    /// The electrorheological damper; none for a machine without one.
    pub er: Option<Er>,
    /// Friction over the Coulomb level near standstill.
    pub stribeck: Option<Stribeck>,
    /// What friction has more of in the positive direction.
    pub asymmetry: Asymmetry,
    /// Dry friction as a bristle (Dahl) of this stiffness, N m/rad (N/m), above 0; none for true stiction. The bristle
    /// stands for Coulomb friction only, the fluid still holds.
    pub presliding_stiffness: Option<f64>,
    /// Dry friction over the Coulomb level for each N m of the drive's torque, 1, not negative and below 1: level + this times
    /// |torque|. What bearings, screws and gears transmit presses them together (Bittencourt and Gunnarsson, J. Dyn. Syst.
    /// Meas. Control 134 (2012), article 051013, whose level over the load is this straight line).
    pub load_friction: f64,
    /// The viscous coefficient falls with the heat that all drag makes; none for a constant one.
    pub viscous_warming: Option<Warming>,
    /// Drag coefficient of w |w|, N m s2/rad2 (N s2/m2), not negative.
    pub quadratic_drag: f64,
    /// Cogging, one entry an order.
    pub cogging: Vec<Harmonic>,
    /// The drive's torque is 1 + these times itself, one entry an order, amplitudes below 1 in all: flux and current of a motor
    /// are no perfect sines (Holtz and Springob, IEEE Trans. Ind. Electron. 43 (1996) 309).
    pub torque_ripple: Vec<Harmonic>,
    /// Unbalanced load.
    pub gravity: Option<Gravity>,
    /// Spring to position zero, N m/rad (N/m), not negative.
    pub spring_stiffness: f64,
    /// Load on a flexible shaft, with or without backlash.
    pub shaft: Option<Shaft>,
    /// Pushes from outside.
    pub pulses: Vec<Pulse>,
    /// Steady sine from outside.
    pub vibration: Option<Vibration>,
    /// What the position sensor adds.
    pub sensor: SensorModel,
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
    /// The field acts as this times the field, 1, not negative.
    pub field_gain: f64,
    /// The torque is this times the law, 1, not negative.
    pub scale: f64,
    /// The torque is (1 + this times t) times the law, 1/s; never below zero.
    pub drift_per_s: f64,
    /// The torque falls with the heat that all drag makes; none for a constant one.
    pub warming: Option<Warming>,
    /// Below yield the fluid is a spring of this stiffness, N m/rad (N/m), above 0; none for a fluid that holds rigidly.
    /// Only for [`FluidResponse::Field`]. Elastic up to the torque of the field, ideally plastic there: a field that
    /// falls takes the surplus of the spring away.
    pub preyield_stiffness: Option<f64>,
}

/// Highest field the damper is ever given, kV/mm (control specification section 3); it bounds what the fluid can do.
pub const HIGHEST_FIELD_KV_MM: f64 = 3.5;

/// How the fluid follows the commanded field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FluidResponse {
    /// The field is delayed; the drag is a E^2 + b E of the delayed field.
    Field(FieldResponse),
    /// The coefficient of viscosity Q = (a E^2 + b E) / max(|w_est|, 0.002) is delayed; the drag is Q_delayed |w|.
    ViscosityDeadTime {
        /// L_Q, s.
        dead_time_s: f64,
        /// Largest drag the fluid gives, Q |w| and the brake's together, N m (N); infinite for none.
        torque_limit: f64,
    },
    /// As above with a first-order lag in place of the dead time.
    ViscosityLag {
        /// T_Q, s.
        lag_s: f64,
        /// Largest drag the fluid gives, Q |w| and the brake's together, N m (N); infinite for none.
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
    /// How both depend on the field; the default is not at all.
    pub kinetics: Kinetics,
    /// The fluid's own flow beside its yield; none for the set-valued a E^2 + b E alone, as in the paper.
    pub flow: Option<FlowCurve>,
}

/// A slew limit beyond this is none: 3.5 kV/mm pass in 35 ns, and the formulas of a ramp would lose their digits.
const FASTEST_SLEW_KV_MM_S: f64 = 1e8;

impl FieldResponse {
    /// Dead time and one lag for both directions, s.
    pub fn new(dead_time_s: f64, lag_s: f64) -> Self {
        Self { dead_time_s, rise_s: lag_s, fall_s: lag_s, ..Self::default() }
    }
}

impl Er {
    /// A damper a E^2 + b E with dead time and lag of the field, s.
    pub fn new(a: f64, b: f64, dead_time_s: f64, lag_s: f64) -> Self {
        Self {
            a,
            b,
            response: FluidResponse::Field(FieldResponse::new(dead_time_s, lag_s)),
            field_gain: 1.0,
            scale: 1.0,
            drift_per_s: 0.0,
            warming: None,
            preyield_stiffness: None,
        }
    }

    /// Torque of a damper a E^2 + b E at [`HIGHEST_FIELD_KV_MM`], N m (N): more a fluid cannot give, whatever its delay.
    /// Without that bound a late coefficient of viscosity times a high speed is any torque.
    pub fn largest_torque(a: f64, b: f64) -> f64 {
        (a * HIGHEST_FIELD_KV_MM + b) * HIGHEST_FIELD_KV_MM
    }

    /// The a and b of the commanded field, with field gain and scale in them.
    pub fn acting(&self) -> (f64, f64) {
        (self.a * self.field_gain * self.field_gain * self.scale, self.b * self.field_gain * self.scale)
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
            torque_deadband: 0.0,
            torque_delay_s: 0.0,
            torque_lag_s: 0.0,
            er: None,
            stribeck: None,
            asymmetry: Asymmetry::default(),
            presliding_stiffness: None,
            load_friction: 0.0,
            viscous_warming: None,
            quadratic_drag: 0.0,
            cogging: Vec::new(),
            torque_ripple: Vec::new(),
            gravity: None,
            spring_stiffness: 0.0,
            shaft: None,
            pulses: Vec::new(),
            vibration: None,
            sensor: SensorModel::default(),
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
        positive("torque_gain", self.torque_gain)?;
        finite("torque_offset", self.torque_offset)?;
        if let Some(limit) = self.torque_limit {
            positive("torque_limit", limit)?;
        }
        not_negative("torque_deadband", self.torque_deadband)?;
        not_negative("torque_delay_s", self.torque_delay_s)?;
        not_negative("torque_lag_s", self.torque_lag_s)?;
        friction::validate(self)?;
        position::validate(self)?;
        self.shaft.as_ref().map_or(Ok(()), Shaft::validate)?;
        self.pulses.iter().try_for_each(Pulse::validate)?;
        self.vibration.as_ref().map_or(Ok(()), Vibration::validate)?;
        self.sensor.validate()?;
        self.er.as_ref().map_or(Ok(()), Er::validate)
    }
}

impl Er {
    fn validate(&self) -> Result<(), Error> {
        let Self { a, b, response, field_gain, scale, drift_per_s, warming, preyield_stiffness } = self;
        not_negative("er.a", *a)?;
        not_negative("er.b", *b)?;
        not_negative("er.field_gain", *field_gain)?;
        not_negative("er.scale", *scale)?;
        finite("er.drift_per_s", *drift_per_s)?;
        warming.map_or(Ok(()), |warming| warming.validate("er.warming"))?;
        if let Some(stiffness) = *preyield_stiffness {
            let field = matches!(response, FluidResponse::Field(_));
            check("er.preyield_stiffness", stiffness, field, "left out where the viscosity is delayed")?;
            positive("er.preyield_stiffness", stiffness)?;
        }
        match *response {
            FluidResponse::Field(FieldResponse { dead_time_s, slew_kv_mm_s, rise_s, fall_s, kinetics, flow }) => {
                kinetics.validate()?;
                flow.map_or(Ok(()), |flow| {
                    let rigid = preyield_stiffness.is_none();
                    check(
                        "er.flow.exponent",
                        flow.exponent,
                        rigid,
                        "left out where the fluid is a spring below yield",
                    )?;
                    flow.validate()
                })?;
                not_negative("er.dead_time_s", dead_time_s)?;
                not_negative("er.rise_s", rise_s)?;
                not_negative("er.fall_s", fall_s)?;
                slew_kv_mm_s.map_or(Ok(()), |slew| {
                    check(
                        "er.slew_kv_mm_s",
                        slew,
                        slew > 0.0 && slew <= FASTEST_SLEW_KV_MM_S,
                        "above 0 and at most 1e8",
                    )
                })
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
