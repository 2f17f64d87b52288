//! Every law of motion without a closed form: collocation between the same events as the nominal machine.

use super::collocation::{Collocation, NODES};
use super::events::{Balance, Flow};
use super::exact::Exact;
use super::fluid::{FluidInput, FluidLaw};
use super::series;
use super::state::{Motion, State};
use crate::effects::friction::{FASTEST_S, Friction};
use crate::effects::position::{PositionTorque, Ripple};
use crate::effects::shaft::{Contact, ShaftLaw};
use crate::effects::{Vibration, Warming};
use crate::{Model, Segment, Signal};

/// Work around a step, of its length, its input and its events, in steps of a law with a closed form, each of which takes
/// about as long as an iteration of the collocation: the ratio of their measured times.
const AROUND_STEP: u32 = 2;
/// Of a power series with what is around it.
const SERIES_WORK: u32 = 2;

/// All effects at once.
#[derive(Debug, Clone)]
pub(crate) struct General {
    /// What the motor torque moves: all of it, or the motor in front of the shaft, kg m2.
    inertia: f64,
    /// One over that: it is asked for at every node.
    per_inertia: f64,
    friction: Friction,
    position: PositionTorque,
    ripple: Ripple,
    vibration: Option<Vibration>,
    fluid: FluidLaw,
    drift_per_s: f64,
    /// Of viscous friction and of the fluid; none where nothing warms.
    warming: Option<[Warming; 2]>,
    shaft: Option<ShaftLaw>,
    /// Everything but the shaft, where that has a closed form.
    without_shaft: Option<Exact>,
    method: Collocation,
}

/// What acts at one time, whatever the motion.
#[derive(Debug, Clone, Copy, Default)]
struct Input {
    /// Torque of the drive before its ripple, N m.
    drive: f64,
    /// Torque from outside, N m.
    outside: f64,
    /// Of the cold fluid.
    fluid: FluidInput,
}

impl General {
    /// From a validated model.
    pub(crate) fn new(model: &Model) -> Self {
        let shaft = model.shaft.as_ref().and_then(|shaft| ShaftLaw::new(shaft, model.inertia));
        let ripple = Ripple::new(model);
        let (friction, position, fluid) = (Friction::new(model), PositionTorque::new(model), FluidLaw::new(model));
        // The cost of a second must not grow with stiffness over inertia.
        let least = friction.least_inertia().max(position.least_inertia()).max(fluid.least_inertia(model));
        let inertia = shaft.map_or(model.inertia, |shaft| shaft.motor_inertia).max(least);
        Self {
            inertia,
            per_inertia: inertia.recip(),
            friction,
            position,
            ripple,
            // A faster one has no time to move the rotor.
            vibration: model.vibration.filter(|vibration| vibration.frequency_hz * FASTEST_S < 1.0),
            fluid,
            drift_per_s: model.er.as_ref().map_or(0.0, |er| er.drift_per_s),
            warming: warming(model),
            shaft,
            without_shaft: without_shaft(model),
            method: Collocation::new(),
        }
    }

    fn input(&self, segment: &Segment, t: f64) -> Input {
        let t_s = segment.start_s + t;
        let mut outside = segment.external_torque;
        if let Some(vibration) = &self.vibration {
            outside += vibration.torque(t_s);
        }
        let strength = (1.0 + self.drift_per_s * t_s).max(0.0);
        let fluid = match self.fluid {
            FluidLaw::Field { a, b } => {
                let field = segment.fluid.at(t);
                FluidInput { level: strength * (a * field + b) * field, ..FluidInput::default() }
            }
            FluidLaw::Flowing { a, b, curve } => {
                let field = segment.fluid.at(t);
                FluidInput {
                    level: strength * (a * field + b) * field,
                    consistency: strength * curve.at(field),
                    ..FluidInput::default()
                }
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
        Input { drive: segment.torque.at(t), outside, fluid }
    }

    /// Drag of friction and fluid, signed like the motion, N m, for a position and speed reached from `x` in its regime with that
    /// heat in friction and fluid.
    #[inline]
    fn drag(&self, input: &Input, x: &State, position: f64, w: f64, heat_j: [f64; 2]) -> f64 {
        let sign = x.motion.sign();
        let travel = position - x.position;
        let bristle =
            if self.friction.is_bristle() { self.friction.bristle_after(sign, x.bristle_torque, travel) } else { 0.0 };
        let drive = self.drive(input, position);
        let Some([friction, fluid]) = &self.warming else {
            return self.friction.torque(sign, w, bristle, drive, 1.0) + self.fluid.torque(&input.fluid, x, travel, w);
        };
        let (viscous_share, share) = (friction.share(heat_j[0]), fluid.share(heat_j[1]));
        self.friction.torque(sign, w, bristle, drive, viscous_share)
            + self.fluid.torque(&input.fluid.times(share), x, travel, w)
    }

    /// Torque of the drive at a position, N m.
    #[inline]
    fn drive(&self, input: &Input, position: f64) -> f64 {
        input.drive * self.ripple.gain(position)
    }

    /// Torque on the motor other than that of the shaft, N m, as [`General::drag`].
    #[inline]
    fn torque(&self, input: &Input, x: &State, position: f64, w: f64, heat_j: [f64; 2]) -> f64 {
        self.push(input, position) - self.drag(input, x, position, w, heat_j)
    }

    /// Torque of drive, surroundings and position, N m.
    #[inline]
    fn push(&self, input: &Input, position: f64) -> f64 {
        self.drive(input, position) + input.outside + self.position.torque(position)
    }

    /// Accelerations of the motor and of the twist behind it.
    #[inline]
    fn accelerations(
        &self,
        shaft: &ShaftLaw,
        input: &Input,
        x: &State,
        (q, v): ([f64; 2], [f64; 2]),
        heat_j: [f64; 2],
    ) -> [f64; 2] {
        let through = shaft.torque(x.contact, q[1], v[1]);
        let motor = if x.motion == Motion::Stuck {
            0.0
        } else {
            (self.torque(input, x, q[0], v[0], heat_j) + through) * self.per_inertia
        };
        [motor, -through * shaft.per_load_inertia - motor]
    }

    /// Torque of the shaft on the motor, N m.
    fn shaft_torque(&self, x: &State) -> f64 {
        self.shaft.map_or(0.0, |shaft| shaft.torque(x.contact, x.twist, x.twist_rate))
    }

    fn acceleration_at(&self, input: &Input, x: &State) -> f64 {
        (self.torque(input, x, x.position, x.velocity, heat(x)) + self.shaft_torque(x)) / self.inertia
    }

    /// What the fluid can do with the heat of `x` in it.
    fn fluid_input(&self, segment: &Segment, t: f64, x: &State) -> FluidInput {
        let input = self.input(segment, t);
        let Some([_, fluid]) = &self.warming else { return input.fluid };
        let mut warm = input.fluid.times(fluid.share(x.fluid_heat_j));
        if warm.yield_torque > 0.0 {
            let power_w = self.drag(&input, x, x.position, x.velocity, heat(x)) * x.velocity;
            warm.yield_rate -= fluid.per_j * fluid.rate_w(x.fluid_heat_j, power_w) * warm.yield_torque;
        }
        warm
    }

    /// A step of a machine without a shaft and without heat.
    fn rotor_step(&self, inputs: &[Input; NODES], x: &State, h: f64) -> (State, u32) {
        let first = [self.torque(&inputs[0], x, x.position, x.velocity, [0.0; 2]) * self.per_inertia];
        let (q, v, iterations) = self.method.step(([x.position], [x.velocity]), [first; NODES], h, |node, q, v| {
            [self.torque(&inputs[node], x, q[0], v[0], [0.0; 2]) * self.per_inertia]
        });
        (State { position: q[0], velocity: v[0], ..*x }, iterations)
    }

    /// A step with a load behind a shaft where the rest has a closed form; none where what drives it changes within less.
    fn linear_step(&self, shaft: &ShaftLaw, segment: &Segment, t: f64, x: &State, h: f64) -> Option<State> {
        let (push, viscous) = self.without_shaft.as_ref()?.push(segment, t, x)?;
        push.is_smooth(h).then(|| series::step(shaft, self.per_inertia, &push, viscous, x, h))
    }

    /// A step with a load behind a shaft.
    fn shaft_step(&self, shaft: &ShaftLaw, inputs: &[Input; NODES], x: &State, h: f64) -> (State, u32) {
        let start = ([x.position, x.twist], [x.velocity, x.twist_rate]);
        let first = self.accelerations(shaft, &inputs[0], x, start, [0.0; 2]);
        let rate = shaft.torque_rate(x.contact, x.twist_rate, first[1]);
        let motor = if x.motion == Motion::Stuck { 0.0 } else { rate * self.per_inertia };
        let rates = [motor, -rate * shaft.per_load_inertia - motor];
        let guess = self.method.times.map(|time| std::array::from_fn(|body| first[body] + h * time * rates[body]));
        let (q, v, iterations) = self
            .method
            .step(start, guess, h, |node, q, v| self.accelerations(shaft, &inputs[node], x, (*q, *v), [0.0; 2]));
        (State { position: q[0], twist: q[1], velocity: v[0], twist_rate: v[1], ..*x }, iterations)
    }

    /// A step in which friction and fluid warm: heats are speeds of two bodies more, of which nobody asks the position.
    fn warm_step(&self, warming: &[Warming; 2], inputs: &[Input; NODES], x: &State, h: f64) -> (State, u32) {
        let rates = |node: usize, q: &[f64; 4], v: &[f64; 4]| {
            let (input, heat_j) = (&inputs[node], [v[2], v[3]]);
            let [motor, twist] = match &self.shaft {
                Some(shaft) => self.accelerations(shaft, input, x, ([q[0], q[1]], [v[0], v[1]]), heat_j),
                None => [self.torque(input, x, q[0], v[0], heat_j) * self.per_inertia, 0.0],
            };
            let still = x.motion == Motion::Stuck;
            let power_w = if still { 0.0 } else { self.drag(input, x, q[0], v[0], heat_j) * v[0] };
            [motor, twist, warming[0].rate_w(v[2], power_w), warming[1].rate_w(v[3], power_w)]
        };
        let start = ([x.position, x.twist, 0.0, 0.0], [x.velocity, x.twist_rate, x.friction_heat_j, x.fluid_heat_j]);
        let first = rates(0, &start.0, &start.1);
        let (q, v, iterations) = self.method.step(start, [first; NODES], h, rates);
        let [velocity, twist_rate, friction_heat_j, fluid_heat_j] = v;
        (State { position: q[0], twist: q[1], velocity, twist_rate, friction_heat_j, fluid_heat_j, ..*x }, iterations)
    }
}

/// Heat of friction and fluid, J.
fn heat(x: &State) -> [f64; 2] {
    [x.friction_heat_j, x.fluid_heat_j]
}

/// The machine of a model without its shaft, where that has a closed form.
fn without_shaft(model: &Model) -> Option<Exact> {
    model.shaft.as_ref()?;
    let rigid = Model { shaft: None, ..model.clone() };
    Exact::covers(&rigid).then(|| Exact::new(&rigid))
}

/// Heat stores of friction and fluid, none where nothing warms.
fn warming(model: &Model) -> Option<[Warming; 2]> {
    let fluid = model.er.as_ref().and_then(|er| er.warming);
    let any = model.viscous_warming.is_some() || fluid.is_some();
    any.then(|| [model.viscous_warming, fluid].map(|warming| warming.unwrap_or(Warming::NONE)))
}

impl Flow for General {
    fn step(&self, segment: &Segment, t: f64, x: &State, h: f64) -> (State, u32) {
        if x.motion == Motion::Stuck && self.shaft.is_none() {
            let mut next = *x;
            if let Some([friction, fluid]) = &self.warming {
                (next.friction_heat_j, _) = friction.after(x.friction_heat_j, 0.0, h);
                (next.fluid_heat_j, _) = fluid.after(x.fluid_heat_j, 0.0, h);
            }
            next.spring_torque = self.fluid.spring(&self.fluid_input(segment, t + h, &next), x, 0.0);
            return (next, AROUND_STEP);
        }
        if let Some(shaft) = &self.shaft
            && let Some(next) = self.linear_step(shaft, segment, t, x, h)
        {
            return (next, SERIES_WORK);
        }
        let inputs: [Input; NODES] = std::array::from_fn(|node| self.input(segment, t + h * self.method.times[node]));
        let (mut next, iterations) = match (&self.warming, &self.shaft) {
            (Some(warming), _) => self.warm_step(warming, &inputs, x, h),
            (None, Some(shaft)) => self.shaft_step(shaft, &inputs, x, h),
            (None, None) => self.rotor_step(&inputs, x, h),
        };
        let travel = next.position - x.position;
        if self.friction.is_bristle() {
            next.bristle_torque = self.friction.bristle_after(x.motion.sign(), x.bristle_torque, travel);
        }
        if matches!(self.fluid, FluidLaw::Spring { .. }) {
            next.spring_torque = self.fluid.spring(&self.fluid_input(segment, t + h, &next), x, travel);
        }
        (next, AROUND_STEP + iterations)
    }

    fn acceleration(&self, segment: &Segment, t: f64, x: &State) -> f64 {
        self.acceleration_at(&self.input(segment, t), x)
    }

    fn rest_balance(&self, segment: &Segment, t: f64, x: &State) -> Balance {
        let (input, fluid) = (self.input(segment, t), self.fluid_input(segment, t, x));
        let spring = self.fluid.spring(&fluid, &State { motion: Motion::Stuck, ..*x }, 0.0);
        let held = if self.friction.is_bristle() { x.bristle_torque } else { 0.0 };
        let push = self.push(&input, x.position) + self.shaft_torque(x) - spring - held;
        Balance { push, hold: self.friction.hold(push, self.drive(&input, x.position)) + fluid.level }
    }

    fn longest_step(&self, segment: &Segment, t: f64, x: &State) -> f64 {
        let input = self.input(segment, t);
        // A ripple at most doubles the drive's torque.
        let drive = 2.0 * input.drive.abs();
        let torque = drive
            + input.outside.abs()
            + input.fluid.level
            + input.fluid.yield_torque
            + self.position.bound(x.position)
            + self.friction.torque(1.0, x.velocity.abs(), x.bristle_torque.abs(), drive, 1.0)
            + self.friction.hold(1.0, drive)
            + self.friction.coulomb(-1.0)
            + self.shaft_torque(x).abs()
            + self.fluid.flow(&input.fluid, x.velocity);
        let acceleration = 2.0 * torque / self.inertia;
        let sign = x.motion.sign();
        let mut step = self.friction.longest_step(sign, x.velocity, x.bristle_torque, acceleration, self.inertia);
        step = step.min(self.position.longest_step(x.velocity, acceleration, self.inertia));
        step = step.min(self.fluid.longest_step(&input.fluid, x.velocity, acceleration, self.inertia));
        step = step.min(0.5 * self.inertia / input.fluid.viscosity);
        step = step.min(self.ripple.longest_step(input.drive, x.velocity, acceleration, self.inertia));
        if let Some(warming) = &self.warming {
            let power_w = torque * x.velocity.abs();
            step = warming.iter().fold(step, |step, warming| step.min(warming.longest_step(power_w)));
        }
        if self.friction.follows_load() {
            // Friction over the load has a kink where the drive's torque changes sign.
            step = step.min(segment.torque.rebased(t).zero_s().unwrap_or(f64::INFINITY));
        }
        for signal in [&segment.torque, &segment.fluid, &segment.brake_torque] {
            step = step.min(time_scale(signal));
        }
        if let Some(vibration) = &self.vibration {
            step = step.min(0.16 / vibration.frequency_hz);
        }
        self.shaft.map_or(step, |shaft| step.min(shaft.longest_step()))
    }

    fn rest_is_monotone(&self, segment: &Segment) -> bool {
        let rests = self.shaft.is_none() && self.vibration.is_none() && segment.torque.amplitude == 0.0;
        rests && !self.fluid_drifts()
    }

    fn enter(&self, segment: &Segment, t: f64, x: &mut State) {
        if !matches!(self.fluid, FluidLaw::Field { .. }) {
            self.fluid.enter(&self.fluid_input(segment, t, x), x);
        }
        if let Some(shaft) = &self.shaft {
            x.contact = shaft.contact(x.twist, x.twist_rate);
        }
    }

    fn guard(&self, segment: &Segment, t: f64, x: &State) -> f64 {
        let contact = self.shaft.map_or(f64::INFINITY, |shaft| shaft.guard(x.contact, x.twist, x.twist_rate));
        if matches!(self.fluid, FluidLaw::Field { .. }) {
            return contact;
        }
        contact.min(self.fluid.guard(&self.fluid_input(segment, t, x), x))
    }

    fn leave_regime(&self, segment: &Segment, t: f64, x: &mut State) {
        let fluid = self.fluid.guard(&self.fluid_input(segment, t, x), x);
        match self.shaft {
            Some(shaft) if shaft.guard(x.contact, x.twist, x.twist_rate) < fluid => {
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
        self.drift_per_s != 0.0 || self.warming.is_some()
    }
}

/// Longest step on which a signal is smooth, s.
fn time_scale(signal: &Signal) -> f64 {
    if signal.amplitude == 0.0 { f64::INFINITY } else { signal.rate.recip() }
}
