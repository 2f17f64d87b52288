//! Every law of motion without a closed form: collocation between the same events as the nominal machine.

use super::collocation::{Collocation, NODES};
use super::events::{Balance, Flow};
use super::fluid::{FluidInput, FluidLaw};
use super::state::{Motion, State};
use crate::effects::Vibration;
use crate::effects::friction::{FASTEST_S, Friction};
use crate::effects::position::PositionTorque;
use crate::effects::shaft::{Contact, ShaftLaw};
use crate::{Model, Segment, Signal};

/// All effects at once.
#[derive(Debug, Clone)]
pub(crate) struct General {
    /// What the motor torque moves: all of it, or the motor in front of the shaft, kg m2.
    inertia: f64,
    /// One over that: it is asked for at every node.
    per_inertia: f64,
    friction: Friction,
    position: PositionTorque,
    vibration: Option<Vibration>,
    fluid: FluidLaw,
    drift_per_s: f64,
    shaft: Option<ShaftLaw>,
    method: Collocation,
}

/// What acts at one time, whatever the motion.
#[derive(Debug, Clone, Copy, Default)]
struct Input {
    /// Motor torque and torque from outside, N m.
    push: f64,
    fluid: FluidInput,
}

impl General {
    /// From a validated model.
    pub(crate) fn new(model: &Model) -> Self {
        let shaft = model.shaft.as_ref().and_then(|shaft| ShaftLaw::new(shaft, model.inertia));
        let (friction, position, fluid) = (Friction::new(model), PositionTorque::new(model), FluidLaw::new(model));
        // The cost of a second must not grow with stiffness over inertia.
        let least = friction.least_inertia().max(position.least_inertia()).max(fluid.least_inertia(model));
        let inertia = shaft.map_or(model.inertia, |shaft| shaft.motor_inertia).max(least);
        Self {
            inertia,
            per_inertia: inertia.recip(),
            friction,
            position,
            // A faster one has no time to move the rotor.
            vibration: model.vibration.filter(|vibration| vibration.frequency_hz * FASTEST_S < 1.0),
            fluid,
            drift_per_s: model.er.as_ref().map_or(0.0, |er| er.drift_per_s),
            shaft,
            method: Collocation::new(),
        }
    }

    fn input(&self, segment: &Segment, t: f64) -> Input {
        let t_s = segment.start_s + t;
        let mut push = segment.torque.at(t) + segment.external_torque;
        if let Some(vibration) = &self.vibration {
            push += vibration.torque(t_s);
        }
        let strength = (1.0 + self.drift_per_s * t_s).max(0.0);
        let fluid = match self.fluid {
            FluidLaw::Field { a, b } => {
                let field = segment.fluid.at(t);
                FluidInput { level: strength * (a * field + b) * field, ..FluidInput::default() }
            }
            FluidLaw::Spring { a, b, .. } => {
                let field = segment.fluid.at(t);
                let torque = (a * field + b) * field;
                let mut rate = strength * (2.0 * a * field + b) * segment.fluid.rate_at(t);
                if strength > 0.0 {
                    rate += self.drift_per_s * torque;
                }
                // The sum of a constant and an exponential may end a hair below zero.
                FluidInput { yield_torque: (strength * torque).max(0.0), yield_rate: rate, ..FluidInput::default() }
            }
            FluidLaw::Viscosity { .. } => FluidInput {
                level: strength * segment.brake_torque.at(t),
                viscosity: strength * segment.fluid.at(t),
                ..FluidInput::default()
            },
        };
        Input { push, fluid }
    }

    /// Torque on the motor other than that of the shaft, N m, for a position and speed reached from `x` in its regime.
    #[inline]
    fn torque(&self, input: &Input, x: &State, position: f64, w: f64) -> f64 {
        let sign = x.motion.sign();
        let travel = position - x.position;
        let bristle =
            if self.friction.is_bristle() { self.friction.bristle_after(sign, x.bristle_torque, travel) } else { 0.0 };
        input.push + self.position.torque(position)
            - self.friction.torque(sign, w, bristle)
            - self.fluid.torque(&input.fluid, x, travel, w)
    }

    /// Accelerations of the motor and of the twist behind it.
    #[inline]
    fn accelerations(&self, shaft: &ShaftLaw, input: &Input, x: &State, q: &[f64; 2], v: &[f64; 2]) -> [f64; 2] {
        let through = shaft.torque(x.contact, q[1], v[1]);
        let motor = if x.motion == Motion::Stuck {
            0.0
        } else {
            (self.torque(input, x, q[0], v[0]) + through) * self.per_inertia
        };
        [motor, -through * shaft.per_load_inertia - motor]
    }

    /// Torque of the shaft on the motor, N m.
    fn shaft_torque(&self, x: &State) -> f64 {
        self.shaft.map_or(0.0, |shaft| shaft.torque(x.contact, x.twist, x.twist_rate))
    }

    fn acceleration_at(&self, input: &Input, x: &State) -> f64 {
        (self.torque(input, x, x.position, x.velocity) + self.shaft_torque(x)) / self.inertia
    }
}

impl Flow for General {
    fn step(&self, segment: &Segment, t: f64, x: &State, h: f64) -> State {
        let mut next = *x;
        if x.motion == Motion::Stuck && self.shaft.is_none() {
            next.spring_torque = self.fluid.spring(&self.input(segment, t + h).fluid, x, 0.0);
            return next;
        }
        let inputs: [Input; NODES] = std::array::from_fn(|node| self.input(segment, t + h * self.method.times[node]));
        if let Some(shaft) = &self.shaft {
            let start = ([x.position, x.twist], [x.velocity, x.twist_rate]);
            let first = self.accelerations(shaft, &inputs[0], x, &start.0, &start.1);
            let rate = shaft.torque_rate(x.contact, x.twist_rate, first[1]);
            let motor = if x.motion == Motion::Stuck { 0.0 } else { rate * self.per_inertia };
            let rates = [motor, -rate * shaft.per_load_inertia - motor];
            let guess = self.method.times.map(|time| std::array::from_fn(|body| first[body] + h * time * rates[body]));
            let (q, v) =
                self.method.step(start, guess, h, |node, q, v| self.accelerations(shaft, &inputs[node], x, q, v));
            [next.position, next.twist] = q;
            [next.velocity, next.twist_rate] = v;
        } else {
            let first = [self.torque(&inputs[0], x, x.position, x.velocity) * self.per_inertia];
            let (q, v) = self.method.step(([x.position], [x.velocity]), [first; NODES], h, |node, q, v| {
                [self.torque(&inputs[node], x, q[0], v[0]) * self.per_inertia]
            });
            [next.position] = q;
            [next.velocity] = v;
        }
        let travel = next.position - x.position;
        if self.friction.is_bristle() {
            next.bristle_torque = self.friction.bristle_after(x.motion.sign(), x.bristle_torque, travel);
        }
        if matches!(self.fluid, FluidLaw::Spring { .. }) {
            next.spring_torque = self.fluid.spring(&self.input(segment, t + h).fluid, x, travel);
        }
        next
    }

    fn acceleration(&self, segment: &Segment, t: f64, x: &State) -> f64 {
        self.acceleration_at(&self.input(segment, t), x)
    }

    fn rest_balance(&self, segment: &Segment, t: f64, x: &State) -> Balance {
        let input = self.input(segment, t);
        let spring = self.fluid.spring(&input.fluid, &State { motion: Motion::Stuck, ..*x }, 0.0);
        let held = if self.friction.is_bristle() { x.bristle_torque } else { 0.0 };
        let push = input.push + self.position.torque(x.position) + self.shaft_torque(x) - spring - held;
        Balance { push, hold: self.friction.hold(push) + input.fluid.level }
    }

    fn longest_step(&self, segment: &Segment, t: f64, x: &State) -> f64 {
        let input = self.input(segment, t);
        let torque = input.push.abs()
            + input.fluid.level
            + input.fluid.yield_torque
            + self.position.bound(x.position)
            + self.friction.torque(1.0, x.velocity.abs(), x.bristle_torque.abs())
            + self.friction.hold(1.0)
            + self.friction.coulomb(-1.0)
            + self.shaft_torque(x).abs();
        let acceleration = 2.0 * torque / self.inertia;
        let sign = x.motion.sign();
        let mut step = self.friction.longest_step(sign, x.velocity, x.bristle_torque, acceleration, self.inertia);
        step = step.min(self.position.longest_step(x.velocity, acceleration, self.inertia));
        step = step.min(self.fluid.longest_step(self.inertia));
        step = step.min(0.5 * self.inertia / input.fluid.viscosity);
        for signal in [&segment.torque, &segment.fluid, &segment.brake_torque] {
            step = step.min(time_scale(signal));
        }
        if let Some(vibration) = &self.vibration {
            step = step.min(0.16 / vibration.frequency_hz);
        }
        self.shaft.map_or(step, |shaft| step.min(shaft.longest_step()))
    }

    fn rest_is_monotone(&self, segment: &Segment) -> bool {
        self.shaft.is_none() && self.vibration.is_none() && segment.torque.amplitude == 0.0 && !self.fluid_drifts()
    }

    fn enter(&self, segment: &Segment, t: f64, x: &mut State) {
        if !matches!(self.fluid, FluidLaw::Field { .. }) {
            self.fluid.enter(&self.input(segment, t).fluid, x);
        }
        if let Some(shaft) = &self.shaft {
            x.contact = shaft.contact(x.twist, x.twist_rate);
        }
    }

    fn guard(&self, segment: &Segment, t: f64, x: &State) -> f64 {
        let contact = self.shaft.map_or(f64::INFINITY, |shaft| shaft.guard(x.contact, x.twist));
        if matches!(self.fluid, FluidLaw::Field { .. }) {
            return contact;
        }
        contact.min(self.fluid.guard(&self.input(segment, t).fluid, x))
    }

    fn leave_regime(&self, segment: &Segment, t: f64, x: &mut State) {
        let fluid = self.fluid.guard(&self.input(segment, t).fluid, x);
        match self.shaft {
            Some(shaft) if shaft.guard(x.contact, x.twist) < fluid => {
                x.contact = match x.contact {
                    Contact::Free if x.twist > 0.0 => Contact::Ahead,
                    Contact::Free => Contact::Behind,
                    _ => Contact::Free,
                };
            }
            _ => self.fluid.leave(x),
        }
    }
}

impl General {
    /// Whether the fluid's level has a trend of its own on top of the field's.
    fn fluid_drifts(&self) -> bool {
        self.drift_per_s != 0.0
    }
}

/// Longest step on which a signal is smooth, s.
fn time_scale(signal: &Signal) -> f64 {
    if signal.amplitude == 0.0 { f64::INFINITY } else { signal.rate.recip() }
}
