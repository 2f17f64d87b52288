//! The nominal machine in closed form.
//!
//! While the rotor slides, J w' = T - s (drag level) - (viscous) w with T and E sums of a constant and an exponential.
//! Squaring the field gives three exponentials, and each of them integrates to [`moments`].

use super::events::{Balance, Flow};
use super::fluid::{FluidInput, FluidLaw, FluidRegime, room};
use super::phi::{field_moments, moments};
use super::series::Push;
use super::state::State;
use crate::effects::Harmonic;
use crate::effects::friction::Friction;
use crate::{Er, FieldResponse, FluidResponse, Model, Segment};

/// Nominal machine: Coulomb and viscous friction, each with its own level a direction, and a fluid that is a field or a
/// held viscosity.
#[derive(Debug, Clone)]
pub(crate) struct Exact {
    inertia: f64,
    friction: Friction,
    fluid: FluidLaw,
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
        Self { inertia: model.inertia, friction: Friction::new(model), fluid: FluidLaw::new(model) }
    }

    /// Whether a model is within what this file solves.
    pub(crate) fn covers(model: &Model) -> bool {
        // Without `..`: a field that an effect adds has to be thought of here.
        let Model {
            inertia: _,
            coulomb: _,
            viscous: _,
            torque_gain: _,
            torque_offset: _,
            torque_limit: _,
            torque_deadband: _,
            torque_delay_s: _,
            torque_lag_s: _,
            er,
            stribeck,
            asymmetry: _,
            presliding_stiffness,
            load_friction,
            viscous_warming,
            quadratic_drag,
            cogging,
            torque_ripple,
            gravity,
            spring_stiffness,
            shaft,
            pulses: _,
            vibration,
            sensor: _,
        } = model;
        let still = |harmonics: &[Harmonic]| harmonics.iter().all(|harmonic| harmonic.amplitude == 0.0);
        let friction = stribeck.is_none_or(|stribeck| stribeck.excess == 0.0)
            && presliding_stiffness.is_none()
            && *load_friction == 0.0
            && viscous_warming.is_none()
            && *quadratic_drag == 0.0;
        let position = still(cogging)
            && still(torque_ripple)
            && gravity.is_none_or(|gravity| gravity.amplitude == 0.0)
            && *spring_stiffness == 0.0;
        let rigid = shaft.is_none_or(|shaft| shaft.inertia_ratio == 0.0);
        let quiet = vibration.is_none_or(|vibration| vibration.amplitude == 0.0);
        er.as_ref().is_none_or(Self::covers_fluid) && friction && position && rigid && quiet
    }

    /// The same of the damper.
    fn covers_fluid(er: &Er) -> bool {
        let Er { a: _, b: _, response, field_gain: _, scale: _, drift_per_s, warming, preyield_stiffness } = er;
        let shape = match response {
            FluidResponse::Field(FieldResponse {
                dead_time_s: _,
                slew_kv_mm_s,
                rise_s: _,
                fall_s: _,
                kinetics: _,
                flow,
            }) => slew_kv_mm_s.is_none() && flow.is_none(),
            FluidResponse::ViscosityDeadTime { dead_time_s: _, torque_limit: _ } => true,
            FluidResponse::ViscosityLag { lag_s, torque_limit: _ } => *lag_s == 0.0,
        };
        shape && *drift_per_s == 0.0 && warming.is_none() && preyield_stiffness.is_none()
    }

    /// The drag from `t` on against motion of that sign, its exponentials counted from there.
    #[inline]
    fn drag(&self, segment: &Segment, t: f64, sign: f64, regime: FluidRegime) -> Drag {
        let (level, viscous) = (self.friction.coulomb(sign), self.friction.viscous(sign));
        match self.fluid {
            FluidLaw::Field { a, b } | FluidLaw::Spring { a, b, .. } | FluidLaw::Flowing { a, b, .. } => {
                let field = segment.fluid.rebased(t);
                let (e, d) = (field.base, field.amplitude);
                Drag { level: level + (a * e + b) * e, linear: (2.0 * a * e + b) * d, square: a * d * d, viscous }
            }
            FluidLaw::Viscosity { torque_limit } => {
                let brake = segment.brake_torque.at(t);
                let (level, viscous) = if regime == FluidRegime::Limited {
                    (level + brake + room(torque_limit, brake), viscous)
                } else {
                    (level + brake, viscous + segment.fluid.at(t))
                };
                Drag { level, linear: 0.0, square: 0.0, viscous }
            }
        }
    }

    /// Torque on a motor that turns as `x` does, from `t` on, and the viscous coefficient that acts beside it; none for a fluid
    /// with a viscosity, which has regimes.
    pub(super) fn push(&self, segment: &Segment, t: f64, x: &State) -> Option<(Push, f64)> {
        let FluidLaw::Field { .. } = self.fluid else { return None };
        let sign = x.motion.sign();
        let (drag, torque) = (self.drag(segment, t, sign, x.fluid_regime), segment.torque.rebased(t));
        let rate = segment.fluid.rate;
        let push = Push {
            constant: torque.base + segment.external_torque - sign * drag.level,
            decays: [(torque.amplitude, torque.rate), (-sign * drag.linear, rate), (-sign * drag.square, 2.0 * rate)],
        };
        Some((push, drag.viscous))
    }

    fn fluid_input(&self, segment: &Segment, t: f64) -> FluidInput {
        FluidInput { level: segment.brake_torque.at(t), viscosity: segment.fluid.at(t), ..FluidInput::default() }
    }
}

impl Flow for Exact {
    #[inline]
    fn step(&self, segment: &Segment, t: f64, x: &State, h: f64) -> (State, u32) {
        let sign = x.motion.sign();
        if sign == 0.0 {
            return (*x, 1);
        }
        let drag = self.drag(segment, t, sign, x.fluid_regime);
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
        (State { position, velocity, ..*x }, 1)
    }

    #[inline]
    fn acceleration(&self, segment: &Segment, t: f64, x: &State) -> f64 {
        let drag = self.drag(segment, t, x.motion.sign(), x.fluid_regime);
        let level = drag.level + drag.linear + drag.square;
        let push = segment.torque.at(t) + segment.external_torque;
        (push - x.motion.sign() * level - drag.viscous * x.velocity) / self.inertia
    }

    #[inline]
    fn rest_balance(&self, segment: &Segment, t: f64, _x: &State) -> Balance {
        let push = segment.torque.at(t) + segment.external_torque;
        let drag = self.drag(segment, t, push, FluidRegime::Free);
        Balance { push, hold: drag.level + drag.linear + drag.square }
    }

    /// No limit: every rate has a closed form, however stiff the drag is against the inertia.
    #[inline]
    fn longest_step(&self, _segment: &Segment, _t: f64, _x: &State) -> f64 {
        f64::INFINITY
    }

    #[inline]
    fn rest_is_monotone(&self, segment: &Segment) -> bool {
        segment.torque.amplitude == 0.0
    }

    #[inline]
    fn enter(&self, segment: &Segment, t: f64, x: &mut State) {
        if matches!(self.fluid, FluidLaw::Viscosity { .. }) {
            self.fluid.enter(&self.fluid_input(segment, t), x);
        }
    }

    #[inline]
    fn guard(&self, segment: &Segment, t: f64, x: &State) -> f64 {
        match self.fluid {
            FluidLaw::Viscosity { .. } => self.fluid.guard(&self.fluid_input(segment, t), x),
            _ => f64::INFINITY,
        }
    }

    fn leave_regime(&self, _segment: &Segment, _t: f64, x: &mut State) {
        self.fluid.leave(x);
    }
}
