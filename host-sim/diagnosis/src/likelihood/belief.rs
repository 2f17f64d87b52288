//! One substep of the belief: an assumed-density (Gaussian) Kalman prediction of the rotor and what hangs on it.
//!
//! State: position, speed, rounding of the sensor, then what the machine has of twist and twist rate of a shaft, bristle torque
//! of dry friction, torque of the fluid's spring, heat in friction and fluid. Torques are averages over the substep; position
//! torques act in its middle (Verlet); linear drag is exact; dry friction is the step of `gaussian`, with the turn within it.

// Matrices are read by their indices, as the equations have them.
#![allow(clippy::needless_range_loop)]

mod bent;
mod covariance;
#[cfg(test)]
mod tests;

use plant::effects::Warming;
use plant::er_fluid::FlowCurve;
use plant::laws::{Friction, PositionTorque, Ripple, ShaftLaw, room};
use plant::{FluidResponse, Model};

use super::acting::{Acting, OfFluid};
use super::gaussian::dry_friction;
use bent::Bent;
pub(crate) use covariance::Linear;

/// Places of the states that every machine has.
pub(crate) const POSITION: usize = 0;
pub(crate) const SPEED: usize = 1;
pub(crate) const ROUNDING: usize = 2;
/// Number of them.
pub(crate) const BASE: usize = 3;

/// The laws of one model, ready to propagate a belief.
#[derive(Debug, Clone)]
pub(crate) struct Laws {
    pub(super) friction: Friction,
    pub(super) position: PositionTorque,
    pub(super) ripple: Ripple,
    pub(super) shaft: Option<ShaftLaw>,
    /// Stiffness and place of the fluid's spring.
    spring: Option<(f64, usize)>,
    pub(super) bristle: Option<usize>,
    twist: Option<usize>,
    /// What warming takes from viscous friction, and the place of its heat.
    pub(super) friction_warming: Option<(Warming, usize)>,
    /// The same of the fluid.
    fluid_warming: Option<(Warming, usize)>,
    /// Limit of the fluid's torque, of viscosity and brake together, N m.
    viscous_limit: f64,
    /// The fluid's flow on top of its yield.
    flow: Option<FlowCurve>,
    pub(super) inertia: f64,
    per_inertia: f64,
    /// Number of states.
    pub(crate) states: usize,
}

/// What acts in one substep.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Substep {
    pub(crate) dt_s: f64,
    pub(crate) torque: f64,
    /// Of that, the drive's before its ripple, N m.
    pub(crate) drive: f64,
    pub(crate) level: f64,
    pub(crate) viscosity: f64,
    /// Consistency of the fluid's flow.
    pub(crate) consistency: f64,
}

impl Substep {
    #[inline]
    pub(crate) fn of(acting: &Acting, index: usize, dt_s: f64) -> Self {
        let at = |values: &[f64]| values.get(index).copied().unwrap_or(0.0);
        let (torque, drive) = (acting.drive.torque[index], acting.drive.drive[index]);
        let OfFluid { level, viscosity, consistency } = &*acting.fluid;
        Self { dt_s, torque, drive, level: at(level), viscosity: at(viscosity), consistency: at(consistency) }
    }
}

/// The free speed at the end of a substep, before dry friction, and what dry friction may take of it.
struct Free {
    speed: f64,
    /// Speed that a torque of one gives over the substep, 1/(N m) rad/s.
    gain: f64,
    /// What is left of the speed after the linear drag.
    kept: f64,
    up: f64,
    down: f64,
    shaft: Bent,
    /// Coefficient of all that is linear in the speed, and of that what warming weakens.
    viscous: (f64, f64),
    /// Slopes of the bristle's torque over its state and the speed.
    bristle: (f64, f64),
    /// Slopes of the spring's torque over its state and the speed.
    spring: (f64, f64),
    /// Torque of bristle and spring.
    elastic: f64,
}

impl Free {
    /// What the torques add to the speed.
    fn push(&self, x: &[f64]) -> f64 {
        self.speed - self.kept * x[SPEED]
    }

    /// Mean speed over the substep, between that at its start and that at its end: of both where the rotor goes on, and where it
    /// comes to rest or turns of each over its own part.
    #[inline]
    fn mean_speed(&self, start: f64, end: f64) -> f64 {
        let push = self.speed - self.kept * start;
        let slowed = if start > 0.0 { self.up - push } else { self.down + push };
        let turns = start.abs() < slowed;
        if !turns {
            return 0.5 * (start + end);
        }
        let before = start.abs() / slowed;
        0.5 * (start * before + end * (1.0 - before))
    }
}

/// (1 - exp(-x)) / x, the mean of a decay over x time constants; 1 for what does not decay.
#[inline]
fn share_of_decay(x: f64) -> f64 {
    // Up to here the next term of the series is below a double's last digit.
    const SHORT: f64 = 0.01;
    if x <= 0.0 {
        1.0
    } else if x < SHORT {
        let terms = [1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5040.0];
        1.0 - x * (terms[0] - x * (terms[1] - x * (terms[2] - x * (terms[3] - x * (terms[4] - x * terms[5])))))
    } else {
        -(-x).exp_m1() / x
    }
}

impl Laws {
    pub(crate) fn new(model: &Model) -> Self {
        // Without `..`: a field that an effect adds has to be thought of here.
        let Model {
            inertia,
            coulomb: _,
            viscous: _,
            torque_gain: _,
            torque_offset: _,
            torque_limit: _,
            torque_deadband: _,
            torque_delay_s: _,
            torque_lag_s: _,
            er,
            stribeck: _,
            asymmetry: _,
            presliding_stiffness,
            load_friction: _,
            viscous_warming,
            quadratic_drag: _,
            cogging: _,
            torque_ripple: _,
            gravity: _,
            spring_stiffness: _,
            shaft,
            pulses: _,
            vibration: _,
            sensor: _,
        } = model;
        let shaft = shaft.as_ref().and_then(|shaft| ShaftLaw::new(shaft, *inertia));
        let mut states = BASE;
        let mut place = |many: usize| {
            states += many;
            states - many
        };
        let twist = shaft.map(|_| place(2));
        let bristle = presliding_stiffness.map(|_| place(1));
        let spring = er.as_ref().and_then(|er| er.preyield_stiffness).map(|stiffness| (stiffness, place(1)));
        let friction_warming = viscous_warming.map(|warming| (warming, place(1)));
        let fluid_warming = er.as_ref().and_then(|er| er.warming).map(|warming| (warming, place(1)));
        let flow = er.as_ref().and_then(|er| match er.response {
            FluidResponse::Field(field) => field.flow,
            _ => None,
        });
        let viscous_limit = match er.as_ref().map(|er| er.response) {
            Some(
                FluidResponse::ViscosityDeadTime { torque_limit, .. }
                | FluidResponse::ViscosityLag { torque_limit, .. },
            ) => torque_limit,
            _ => f64::INFINITY,
        };
        let inertia = shaft.map_or(*inertia, |shaft| shaft.motor_inertia);
        Self {
            friction: Friction::new(model),
            position: PositionTorque::new(model),
            ripple: Ripple::new(model),
            friction_warming,
            fluid_warming,
            inertia,
            per_inertia: inertia.recip(),
            shaft,
            spring,
            bristle,
            twist,
            viscous_limit,
            flow,
            states,
        }
    }

    /// Speed that a torque of one gives in a second, 1/(kg m2).
    pub(crate) fn per_inertia(&self) -> f64 {
        self.per_inertia
    }

    /// Standard deviations of the states at the start of a recording, given those of position and speed and the torque scale;
    /// the machine is `cold` at the start of a recording, and as warm as it may be within one.
    pub(crate) fn spread(&self, position: f64, speed: f64, torque: f64, cold: bool) -> Vec<f64> {
        let mut spread = vec![0.0; self.states];
        (spread[POSITION], spread[SPEED]) = (position, speed);
        if let (Some(at), Some(shaft)) = (self.twist, &self.shaft) {
            spread[at] = shaft.half_gap + torque / shaft.stiffness;
            spread[at + 1] = speed;
        }
        for at in self.bristle.into_iter().chain(self.spring.map(|(_, at)| at)) {
            spread[at] = torque;
        }
        for (warming, at) in self.friction_warming.iter().chain(&self.fluid_warming) {
            spread[*at] = if cold || warming.per_j == 0.0 { 0.0 } else { warming.per_j.recip() };
        }
        spread
    }

    /// What a belief of `N` states has of these: with those of every machine alone nothing, which the compiler then knows.
    #[inline]
    fn beside<const N: usize, T: Copy>(given: &Option<T>) -> Option<T> {
        if N > BASE { *given } else { None }
    }

    #[inline]
    fn twist<const N: usize>(&self) -> Option<usize> {
        Self::beside::<N, _>(&self.twist)
    }

    #[inline]
    fn bristle<const N: usize>(&self) -> Option<usize> {
        Self::beside::<N, _>(&self.bristle)
    }

    #[inline]
    fn spring<const N: usize>(&self) -> Option<(f64, usize)> {
        Self::beside::<N, _>(&self.spring)
    }

    #[inline]
    fn friction_warming<const N: usize>(&self) -> Option<(Warming, usize)> {
        Self::beside::<N, _>(&self.friction_warming)
    }

    #[inline]
    fn fluid_warming<const N: usize>(&self) -> Option<(Warming, usize)> {
        Self::beside::<N, _>(&self.fluid_warming)
    }

    // Over 40 lines: the sum of all torques, each with the place it comes from.
    #[inline]
    fn free<const N: usize>(&self, x: &[f64; N], step: &Substep, twist_sd: f64) -> Free {
        let (w, dt_s) = (x[SPEED], step.dt_s);
        let sign = if w < 0.0 { -1.0 } else { 1.0 };
        let middle = x[POSITION] + 0.5 * dt_s * w;
        let (share, fluid_share) = self.shares(x);
        let (fluid_level, fluid_viscosity) = (fluid_share * step.level, fluid_share * step.viscosity);
        let warm = share * self.friction.viscous(sign);
        let (mut viscous, mut level) = (warm, 0.0);
        if fluid_viscosity > 0.0 {
            let room = room(self.viscous_limit, fluid_level);
            if fluid_viscosity * w.abs() > room {
                level += room;
            } else {
                viscous += fluid_viscosity;
            }
        }
        let drive = step.drive * self.ripple.gain(middle);
        let load = self.friction.of_load(drive);
        let mut torque = step.torque + (drive - step.drive) + self.position.torque(middle);
        let (mut shaft, mut per_inertia) = (Bent::default(), self.per_inertia);
        if let (Some(at), Some(law)) = (self.twist::<N>(), &self.shaft) {
            shaft = Bent::new(law, x[at], x[at + 1], dt_s, twist_sd);
            torque += shaft.torque;
            // What the damper of the shaft holds against a change of speed acts as more inertia.
            per_inertia = (self.inertia + dt_s * shaft.per_change).recip();
        }
        let dry = |sign: f64| if self.bristle::<N>().is_some() { 0.0 } else { self.friction.coulomb(sign) + load };
        let half = 0.5 * dt_s * per_inertia;
        let held = half * (level + dry(sign) + if self.spring::<N>().is_some() { 0.0 } else { fluid_level });
        // What bends over speed is taken at the speed in the middle of the substep.
        let consistency = fluid_share * step.consistency;
        let flow = |speed: f64| self.flow.map_or(0.0, |curve| curve.coefficient(consistency, speed));
        let sliding = w + half * (torque - (viscous + flow(w)) * w);
        let between = if sliding.abs() > held { sliding - held.copysign(sliding) } else { 0.0 };
        viscous += self.friction.quadratic_coefficient() * between.abs() + flow(between);
        let decay = viscous * per_inertia * dt_s;
        let share = share_of_decay(decay);
        let (kept, gain) = (1.0 - decay.max(0.0) * share, share * dt_s * per_inertia);
        let excess = self.friction.excess(between);
        // Bristle and spring are taken as bent in the middle of the substep: at its start they would lag by half of it.
        let mut elastic = 0.0;
        let (mut bristle, mut spring) = ((0.0, 0.0), (0.0, 0.0));
        if let (Some(at), Some(stiffness)) = (self.bristle::<N>(), self.friction.stiffness()) {
            let coulomb = 0.5 * (self.friction.coulomb(1.0) + self.friction.coulomb(-1.0));
            let more = 1.0 + (excess + load) / coulomb.max(f64::MIN_POSITIVE);
            let travel = 0.5 * dt_s * w;
            let level = self.friction.coulomb(sign).max(f64::MIN_POSITIVE);
            let kept = (-stiffness * travel.abs() / level).exp();
            elastic += more * self.friction.bristle_after(travel.signum(), x[at], travel);
            bristle = (more * kept, more * 0.5 * dt_s * stiffness * kept * (1.0 - sign * x[at] / level));
        } else {
            level += excess;
        }
        if let Some((stiffness, at)) = self.spring::<N>() {
            let bent = x[at] + 0.5 * dt_s * stiffness * w;
            // Not `clamp`, which panics where the level of a wild machine is no number.
            elastic += bent.max(-fluid_level.abs()).min(fluid_level.abs());
            let inside = f64::from(bent.abs() < fluid_level);
            spring = (inside, inside * 0.5 * dt_s * stiffness);
        } else {
            level += fluid_level;
        }
        torque -= elastic;
        Free {
            speed: kept * w + gain * torque,
            gain,
            kept,
            up: gain * (level + dry(1.0)).max(0.0),
            down: gain * (level + dry(-1.0)).max(0.0),
            shaft,
            viscous: (viscous, warm),
            elastic,
            bristle,
            spring,
        }
    }

    /// What warming has left of viscous friction and of the fluid, 1.
    #[inline]
    fn shares<const N: usize>(&self, x: &[f64; N]) -> (f64, f64) {
        let share = |warming: Option<(Warming, usize)>| warming.map_or(1.0, |(warming, at)| warming.share(x[at]));
        (share(self.friction_warming::<N>()), share(self.fluid_warming::<N>()))
    }

    /// Power that the drag turns into heat at a speed, W, and its slope over the speed.
    fn power(&self, free: &Free, w: f64) -> (f64, f64) {
        let level = if w < 0.0 { free.down } else { free.up } / free.gain;
        let (viscous, _) = free.viscous;
        (
            ((viscous * w.abs() + level) * w.abs()) + free.elastic * w,
            (2.0 * viscous * w.abs() + level).copysign(w) + free.elastic,
        )
    }

    /// The mean of the state at the end of a substep, for a belief whose free speed spreads by `speed_sd` and whose twist by
    /// `twist_sd`.
    #[inline]
    pub(crate) fn mean<const N: usize>(&self, x: &[f64; N], step: &Substep, speed_sd: f64, twist_sd: f64) -> [f64; N] {
        let free = self.free(x, step, twist_sd);
        let speed = dry_friction(free.speed, speed_sd, free.push(x), free.up, free.down).mean;
        self.moved(x, step, &free, speed)
    }

    #[inline]
    fn moved<const N: usize>(&self, x: &[f64; N], step: &Substep, free: &Free, speed: f64) -> [f64; N] {
        let dt_s = step.dt_s;
        let mut next = *x;
        let travel = dt_s * free.mean_speed(x[SPEED], speed);
        (next[POSITION], next[SPEED]) = (x[POSITION] + travel, speed);
        if let (Some(at), Some(law)) = (self.twist::<N>(), &self.shaft) {
            let change = speed - x[SPEED];
            let torque = free.shaft.torque - free.shaft.per_change * change;
            next[at + 1] = x[at + 1] - dt_s * law.per_load_inertia * torque - change;
            next[at] = x[at] + 0.5 * dt_s * (x[at + 1] + next[at + 1]);
        }
        if let Some(at) = self.bristle::<N>() {
            next[at] = self.friction.bristle_after(travel.signum(), x[at], travel);
        }
        if let Some((stiffness, at)) = self.spring::<N>() {
            let level = self.shares(x).1 * step.level;
            next[at] = (x[at] + stiffness * travel).max(-level).min(level);
        }
        for (warming, at) in self.friction_warming::<N>().into_iter().chain(self.fluid_warming::<N>()) {
            let (power_w, _) = self.power(free, travel / dt_s);
            (next[at], _) = warming.after(x[at], power_w, dt_s);
        }
        next
    }

    /// Keeps what hangs on the rotor where it is, seen from a rotor at `position` and `speed` instead of where `next` has it.
    pub(crate) fn carry<const N: usize>(&self, inside: &mut [f64; N], next: &[f64; N], position: f64, speed: f64) {
        *inside = *next;
        if let Some(at) = self.twist::<N>() {
            inside[at] += next[POSITION] - position;
            inside[at + 1] += next[SPEED] - speed;
        }
    }
}
