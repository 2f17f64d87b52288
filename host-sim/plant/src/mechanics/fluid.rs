//! The fluid seen from the rotor: a drag level from a field, a spring below yield, or a limited viscosity.

use super::state::State;
use crate::effects::friction::{FASTEST_S, followed};
use crate::er_fluid::FlowCurve;
use crate::{FieldResponse, FluidResponse, Model};

/// Highest field of the drive, kV/mm (control.md section 4).
const HIGHEST_KV_MM: f64 = 3.5;
/// Least speed that the coefficient of viscosity is reckoned with, rad/s (control.md section 4).
const SLOWEST_RAD_S: f64 = 0.002;
/// The fastest time constant of a viscosity that is followed, s: shorter than that of the other laws, for at rest the
/// coefficient of a usual fluid on a usual rotor has 60 us.
const FASTEST_VISCOSITY_S: f64 = 1e-5;
/// Part of the limit of a viscosity within which its regime stays as it is: a brake that takes the whole limit leaves nothing but
/// rounding, 1e-16 of it, to tell the regimes by.
const EDGE: f64 = 1e-12;

/// What a brake of `level` leaves of the limit of the fluid's torque to its viscosity, N m (N), not negative: one gap has both
/// (control.md section 5).
#[inline]
pub fn room(torque_limit: f64, level: f64) -> f64 {
    (torque_limit - level).max(0.0)
}

/// Which side of its kinks the fluid is on; part of [`State`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum FluidRegime {
    /// Viscosity below its torque limit; spring below yield; plain field.
    #[default]
    Free,
    /// Viscous torque at its limit; spring at yield in the direction of motion.
    Limited,
    /// Spring loaded against the motion and cut down by a falling field.
    Clipped,
}

/// The fluid's law.
#[derive(Debug, Clone, Copy)]
pub(crate) enum FluidLaw {
    /// Drag a E^2 + b E.
    Field { a: f64, b: f64 },
    /// A spring that yields at a E^2 + b E.
    Spring { a: f64, b: f64, stiffness: f64 },
    /// Drag a E^2 + b E and a flow curve on top of it.
    Flowing { a: f64, b: f64, curve: FlowCurve },
    /// Drag Q |w|, with the brake's limited to this.
    Viscosity { torque_limit: f64 },
}

/// What the fluid can do at one time.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FluidInput {
    /// Set-valued drag, N m.
    pub(crate) level: f64,
    /// Viscous coefficient, N m s/rad.
    pub(crate) viscosity: f64,
    /// Consistency of the flow curve, N m (s/rad)^n.
    pub(crate) consistency: f64,
    /// Torque at which the spring yields, N m, and its rate, N m/s.
    pub(crate) yield_torque: f64,
    pub(crate) yield_rate: f64,
}

impl FluidInput {
    /// Of a fluid that is weaker by a factor.
    pub(crate) fn times(self, share: f64) -> Self {
        Self {
            level: share * self.level,
            viscosity: share * self.viscosity,
            consistency: share * self.consistency,
            yield_torque: share * self.yield_torque,
            yield_rate: share * self.yield_rate,
        }
    }
}

impl FluidLaw {
    /// From a validated model.
    pub(crate) fn new(model: &Model) -> Self {
        let Some(er) = &model.er else { return FluidLaw::Field { a: 0.0, b: 0.0 } };
        let (a, b) = er.acting();
        match (er.response, er.preyield_stiffness) {
            (FluidResponse::Field(FieldResponse { flow: Some(curve), .. }), _) => {
                let curve = FlowCurve { consistency_per_kv_mm: er.field_gain * curve.consistency_per_kv_mm, ..curve };
                FluidLaw::Flowing { a, b, curve }
            }
            (FluidResponse::Field(_), None) => FluidLaw::Field { a, b },
            (FluidResponse::Field(_), Some(stiffness)) => {
                let level = (a * HIGHEST_KV_MM + b) * HIGHEST_KV_MM;
                FluidLaw::Spring { a, b, stiffness: followed(stiffness, level, model.inertia) }
            }
            (FluidResponse::ViscosityDeadTime { torque_limit, .. }, _)
            | (FluidResponse::ViscosityLag { torque_limit, .. }, _) => FluidLaw::Viscosity { torque_limit },
        }
    }

    /// Inertia below which the fluid would be faster than what is followed, kg m2 (kg).
    pub(crate) fn least_inertia(&self, model: &Model) -> f64 {
        let highest = model.er.as_ref().map_or(0.0, |er| {
            let (a, b) = er.acting();
            (a * HIGHEST_KV_MM + b) * HIGHEST_KV_MM / SLOWEST_RAD_S
        });
        match *self {
            FluidLaw::Field { .. } => 0.0,
            FluidLaw::Flowing { curve, .. } => curve.steepest(curve.at(HIGHEST_KV_MM)) * FASTEST_VISCOSITY_S,
            FluidLaw::Spring { stiffness, .. } => stiffness * FASTEST_S * FASTEST_S,
            FluidLaw::Viscosity { .. } => highest * FASTEST_VISCOSITY_S,
        }
    }

    /// Puts a state on the side of the kinks that it is on or is about to be on.
    #[inline]
    pub(crate) fn enter(&self, input: &FluidInput, x: &mut State) {
        match *self {
            FluidLaw::Field { .. } | FluidLaw::Flowing { .. } => {}
            FluidLaw::Viscosity { torque_limit } => {
                let limited = input.viscosity * x.velocity.abs() > room(torque_limit, input.level);
                x.fluid_regime = if limited { FluidRegime::Limited } else { FluidRegime::Free };
            }
            FluidLaw::Spring { stiffness, .. } => {
                x.spring_torque = x.spring_torque.max(-input.yield_torque).min(input.yield_torque);
                let loaded = x.motion.sign() * x.spring_torque;
                let edge = input.yield_torque * (1.0 - 1e-12);
                let loading = stiffness * x.velocity.abs();
                x.fluid_regime = if loaded >= edge && loading >= input.yield_rate {
                    FluidRegime::Limited
                } else if loaded <= -edge && -input.yield_rate > loading {
                    FluidRegime::Clipped
                } else {
                    FluidRegime::Free
                };
            }
        }
    }

    /// Positive while the regime of `x` holds.
    #[inline]
    pub(crate) fn guard(&self, input: &FluidInput, x: &State) -> f64 {
        match (*self, x.fluid_regime) {
            (FluidLaw::Field { .. } | FluidLaw::Flowing { .. }, _) => f64::INFINITY,
            (FluidLaw::Viscosity { torque_limit }, _) if torque_limit.is_infinite() => f64::INFINITY,
            (FluidLaw::Viscosity { torque_limit }, regime) => {
                let beyond = input.viscosity * x.velocity.abs() - room(torque_limit, input.level);
                EDGE * torque_limit + if regime == FluidRegime::Free { -beyond } else { beyond }
            }
            (FluidLaw::Spring { .. }, _) if x.motion.sign() == 0.0 => f64::INFINITY,
            (FluidLaw::Spring { .. }, FluidRegime::Free) => input.yield_torque - x.spring_torque.abs(),
            (FluidLaw::Spring { stiffness, .. }, FluidRegime::Limited) => {
                stiffness * x.motion.sign() * x.velocity - input.yield_rate
            }
            (FluidLaw::Spring { stiffness, .. }, FluidRegime::Clipped) => {
                -input.yield_rate - stiffness * x.motion.sign() * x.velocity
            }
        }
    }

    /// Moves a state whose guard has reached zero to the other side.
    pub(crate) fn leave(&self, x: &mut State) {
        x.fluid_regime = match x.fluid_regime {
            FluidRegime::Limited | FluidRegime::Clipped => FluidRegime::Free,
            FluidRegime::Free if x.motion.sign() * x.spring_torque < 0.0 => FluidRegime::Clipped,
            FluidRegime::Free => FluidRegime::Limited,
        };
    }

    /// Torque of the spring at a node `travel` away from the state `x`, N m; zero for the other laws.
    #[inline]
    pub(crate) fn spring(&self, input: &FluidInput, x: &State, travel: f64) -> f64 {
        let FluidLaw::Spring { stiffness, .. } = *self else { return 0.0 };
        match x.fluid_regime {
            _ if x.motion.sign() == 0.0 => x.spring_torque.max(-input.yield_torque).min(input.yield_torque),
            FluidRegime::Free => x.spring_torque + stiffness * travel,
            FluidRegime::Limited => x.motion.sign() * input.yield_torque,
            FluidRegime::Clipped => -x.motion.sign() * input.yield_torque,
        }
    }

    /// Drag of the fluid while sliding, signed like the motion, N m, at a node `travel` away from the state `x`.
    #[inline]
    pub(crate) fn torque(&self, input: &FluidInput, x: &State, travel: f64, w: f64) -> f64 {
        let dry = x.motion.sign() * input.level;
        match *self {
            FluidLaw::Field { .. } => dry,
            FluidLaw::Flowing { curve, .. } => dry + curve.torque(input.consistency, w),
            FluidLaw::Spring { .. } => self.spring(input, x, travel),
            FluidLaw::Viscosity { torque_limit } if x.fluid_regime == FluidRegime::Limited => {
                dry + x.motion.sign() * room(torque_limit, input.level)
            }
            FluidLaw::Viscosity { .. } => dry + input.viscosity * w,
        }
    }

    /// Drag of the flow curve at a speed, N m, not negative; zero for the other laws.
    #[inline]
    pub(crate) fn flow(&self, input: &FluidInput, w: f64) -> f64 {
        let FluidLaw::Flowing { curve, .. } = *self else { return 0.0 };
        curve.torque(input.consistency, w.abs())
    }

    /// Longest step for the spring or the flow curve, s, at speed `w` and an acceleration of at most `acceleration`.
    pub(crate) fn longest_step(&self, input: &FluidInput, w: f64, acceleration: f64, inertia: f64) -> f64 {
        match *self {
            FluidLaw::Flowing { curve, .. } => curve.longest_step(input.consistency, w, acceleration, inertia),
            FluidLaw::Spring { stiffness, .. } => 0.25 * (inertia / stiffness).sqrt(),
            _ => f64::INFINITY,
        }
    }
}
