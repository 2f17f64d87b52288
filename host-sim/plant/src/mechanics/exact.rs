//! The nominal machine in closed form.
//!
//! While the rotor slides, J w' = T - s (drag level) - (viscous) w with T and E sums of a constant and an exponential.
//! Squaring the field gives three exponentials, and each of them integrates to [`moments`].

use super::events::{Balance, Flow};
use super::phi::{field_moments, moments};
use super::state::{Motion, State};
use crate::{FluidResponse, Model, Segment};

/// Sliding with the viscosity below its torque limit, the regime all other models are always in.
const FLUID_FREE: u8 = 0;
/// Sliding with the viscous drag of the fluid at its limit.
const FLUID_LIMITED: u8 = 1;

/// Nominal machine: Coulomb and viscous friction, and a fluid that is a field or a held viscosity.
#[derive(Debug, Clone)]
pub(crate) struct Exact {
    inertia: f64,
    coulomb: f64,
    viscous: f64,
    fluid: Fluid,
}

/// What the fluid's signal of a segment means.
#[derive(Debug, Clone, Copy)]
enum Fluid {
    /// A field: drag a E^2 + b E.
    Field { a: f64, b: f64 },
    /// A coefficient Q: drag Q |w|, limited.
    Viscosity { torque_limit: f64 },
}

/// Torque level + linear exp(-r t) + square exp(-2 r t) of the dry drag, and the viscous coefficient.
struct Drag {
    level: f64,
    linear: f64,
    square: f64,
    viscous: f64,
}

impl Exact {
    /// From a validated model.
    pub(crate) fn new(model: &Model) -> Self {
        let fluid = match &model.er {
            None => Fluid::Field { a: 0.0, b: 0.0 },
            Some(er) => match er.response {
                FluidResponse::Field(_) => Fluid::Field { a: er.a, b: er.b },
                FluidResponse::ViscosityDeadTime { torque_limit, .. }
                | FluidResponse::ViscosityLag { torque_limit, .. } => Fluid::Viscosity { torque_limit },
            },
        };
        Self { inertia: model.inertia, coulomb: model.coulomb, viscous: model.viscous, fluid }
    }

    /// The drag from `t` on, its exponentials counted from there.
    #[inline]
    fn drag(&self, segment: &Segment, t: f64, regime: u8) -> Drag {
        match self.fluid {
            Fluid::Field { a, b } => {
                let field = segment.fluid.rebased(t);
                let (e, d) = (field.base, field.amplitude);
                Drag {
                    level: self.coulomb + (a * e + b) * e,
                    linear: (2.0 * a * e + b) * d,
                    square: a * d * d,
                    viscous: self.viscous,
                }
            }
            Fluid::Viscosity { torque_limit } => {
                let dry = self.coulomb + segment.brake_torque.at(t);
                let (level, viscous) = if regime == FLUID_LIMITED {
                    (dry + torque_limit, self.viscous)
                } else {
                    (dry, self.viscous + segment.fluid.at(t))
                };
                Drag { level, linear: 0.0, square: 0.0, viscous }
            }
        }
    }

    /// Drag of the fluid at a speed over its limit, N m: positive beyond it.
    fn excess(&self, segment: &Segment, t: f64, x: &State) -> f64 {
        match self.fluid {
            Fluid::Field { .. } => -1.0,
            Fluid::Viscosity { torque_limit } => segment.fluid.at(t) * x.velocity.abs() - torque_limit,
        }
    }
}

impl Flow for Exact {
    #[inline]
    fn step(&self, segment: &Segment, t: f64, x: &State, h: f64) -> State {
        let sign = x.motion.sign();
        let drag = self.drag(segment, t, x.regime);
        let torque = segment.torque.rebased(t);
        let per_inertia = self.inertia.recip();
        let beta = drag.viscous * per_inertia * h;
        let free = moments(0.0, beta);
        let mut velocity = x.velocity * (1.0 - beta * free.0);
        let mut position = x.position + x.velocity * h * free.0;
        let mut add = |torque: f64, (first, second): (f64, f64)| {
            velocity += torque * per_inertia * h * first;
            position += torque * per_inertia * h * h * second;
        };
        add(torque.base + segment.external_torque - sign * drag.level, free);
        if drag.linear != 0.0 {
            let alpha = segment.fluid.rate * h;
            let [linear, square] =
                if beta == 0.0 { field_moments(alpha) } else { [moments(alpha, beta), moments(2.0 * alpha, beta)] };
            add(-sign * drag.linear, linear);
            add(-sign * drag.square, square);
        }
        if torque.amplitude != 0.0 {
            add(torque.amplitude, moments(torque.rate * h, beta));
        }
        State { position, velocity, ..*x }
    }

    #[inline]
    fn acceleration(&self, segment: &Segment, t: f64, x: &State) -> f64 {
        let drag = self.drag(segment, t, x.regime);
        let level = drag.level + drag.linear + drag.square;
        let push = segment.torque.at(t) + segment.external_torque;
        (push - x.motion.sign() * level - drag.viscous * x.velocity) / self.inertia
    }

    #[inline]
    fn rest_balance(&self, segment: &Segment, t: f64, _x: &State) -> Balance {
        let drag = self.drag(segment, t, FLUID_FREE);
        let hold = drag.level + drag.linear + drag.square;
        Balance { push: segment.torque.at(t) + segment.external_torque, hold }
    }

    /// No limit unless viscous friction meets a decaying torque, whose joint series holds up to exponents of one half.
    #[inline]
    fn longest_step(&self, segment: &Segment, t: f64, x: &State) -> f64 {
        let fluid_rate = if segment.fluid.amplitude == 0.0 { 0.0 } else { 2.0 * segment.fluid.rate };
        let torque_rate = if segment.torque.amplitude == 0.0 { 0.0 } else { segment.torque.rate };
        let fastest = fluid_rate.max(torque_rate);
        if fastest == 0.0 {
            return f64::INFINITY;
        }
        let beta = self.drag(segment, t, x.regime).viscous / self.inertia;
        if beta == 0.0 { f64::INFINITY } else { 0.5 / fastest.max(beta) }
    }

    #[inline]
    fn rest_is_monotone(&self, segment: &Segment) -> bool {
        segment.torque.amplitude == 0.0
    }

    #[inline]
    fn enter(&self, segment: &Segment, t: f64, x: &mut State) {
        if matches!(self.fluid, Fluid::Viscosity { .. }) {
            x.regime = if self.excess(segment, t, x) > 0.0 { FLUID_LIMITED } else { FLUID_FREE };
        }
    }

    #[inline]
    fn guard(&self, segment: &Segment, t: f64, x: &State) -> f64 {
        match self.fluid {
            Fluid::Field { .. } => f64::INFINITY,
            Fluid::Viscosity { torque_limit } if torque_limit.is_infinite() => f64::INFINITY,
            Fluid::Viscosity { .. } if x.regime == FLUID_LIMITED => self.excess(segment, t, x),
            Fluid::Viscosity { .. } => -self.excess(segment, t, x),
        }
    }

    fn leave_regime(&self, _segment: &Segment, _t: f64, x: &mut State) {
        x.regime = if x.regime == FLUID_LIMITED { FLUID_FREE } else { FLUID_LIMITED };
        debug_assert!(x.motion != Motion::Stuck, "the fluid's limit is only reached while sliding");
    }
}
