//! One substep of the belief: an assumed-density (Gaussian) Kalman prediction of the rotor and what hangs on it.
//!
//! State: position, speed, rounding of the sensor, then what the machine has of twist and twist rate of a shaft, bristle torque
//! of dry friction, torque of the fluid's spring. Torques are averages over the substep; position torques act in its middle
//! (Verlet); linear drag is exact; dry friction is the proximal step of `gaussian`.

// Matrices are read by their indices, as the equations have them.
#![allow(clippy::needless_range_loop)]

use plant::laws::{Friction, PositionTorque, ShaftLaw};
use plant::{FluidResponse, Model};

use super::acting::Acting;
use super::gaussian::{Thresholded, soft_threshold};
use super::noise::{Noise, Rounding};

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
    pub(super) shaft: Option<ShaftLaw>,
    /// Stiffness and place of the fluid's spring.
    spring: Option<(f64, usize)>,
    pub(super) bristle: Option<usize>,
    twist: Option<usize>,
    /// Limit of the fluid's viscous torque, N m.
    viscous_limit: f64,
    pub(super) inertia: f64,
    /// Number of states.
    pub(crate) states: usize,
}

/// What acts in one substep.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Substep {
    pub(crate) dt_s: f64,
    pub(crate) torque: f64,
    pub(crate) level: f64,
    pub(crate) viscosity: f64,
}

impl Substep {
    #[inline]
    pub(crate) fn of(acting: &Acting, index: usize, dt_s: f64) -> Self {
        let at = |values: &[f64]| values.get(index).copied().unwrap_or(0.0);
        Self { dt_s, torque: acting.torque[index], level: at(&acting.level), viscosity: at(&acting.viscosity) }
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
    /// Torque of the shaft on the motor, its slope over the twist, whether in contact.
    shaft: (f64, f64),
    /// Slope of the position's torque.
    slope: f64,
}

impl Laws {
    pub(crate) fn new(model: &Model) -> Self {
        let shaft = model.shaft.as_ref().and_then(|shaft| ShaftLaw::new(shaft, model.inertia));
        let mut states = BASE;
        let mut place = |many: usize| {
            states += many;
            states - many
        };
        let twist = shaft.map(|_| place(2));
        let bristle = model.presliding_stiffness.map(|_| place(1));
        let er = model.er.as_ref();
        let spring = er.and_then(|er| er.preyield_stiffness).map(|stiffness| (stiffness, place(1)));
        let viscous_limit = match er.map(|er| er.response) {
            Some(
                FluidResponse::ViscosityDeadTime { torque_limit, .. }
                | FluidResponse::ViscosityLag { torque_limit, .. },
            ) => torque_limit,
            _ => f64::INFINITY,
        };
        Self {
            friction: Friction::new(model),
            position: PositionTorque::new(model),
            inertia: shaft.map_or(model.inertia, |shaft| shaft.motor_inertia),
            shaft,
            spring,
            bristle,
            twist,
            viscous_limit,
            states,
        }
    }

    /// Speed that a torque of one gives in a second, 1/(kg m2).
    pub(crate) fn per_inertia(&self) -> f64 {
        self.inertia.recip()
    }

    /// Standard deviations of the states at the start of a recording, given those of position and speed and the torque scale.
    pub(crate) fn spread(&self, position: f64, speed: f64, torque: f64) -> Vec<f64> {
        let mut spread = vec![0.0; self.states];
        (spread[POSITION], spread[SPEED]) = (position, speed);
        if let (Some(at), Some(shaft)) = (self.twist, &self.shaft) {
            spread[at] = shaft.half_gap + torque / shaft.stiffness;
            spread[at + 1] = speed;
        }
        for at in self.bristle.into_iter().chain(self.spring.map(|(_, at)| at)) {
            spread[at] = torque;
        }
        spread
    }

    // Over 40 lines: the sum of all torques, each with the place it comes from.
    #[inline]
    fn free(&self, x: &[f64], step: &Substep, twist_sd: f64) -> Free {
        let (w, dt_s) = (x[SPEED], step.dt_s);
        let sign = if w < 0.0 { -1.0 } else { 1.0 };
        let middle = x[POSITION] + 0.5 * dt_s * w;
        let (mut viscous, mut level) = (self.friction.viscous(sign), 0.0);
        if step.viscosity > 0.0 {
            if step.viscosity * w.abs() > self.viscous_limit {
                level += self.viscous_limit;
            } else {
                viscous += step.viscosity;
            }
        }
        let mut torque = step.torque + self.position.torque(middle);
        let mut shaft = (0.0, 0.0);
        if let (Some(at), Some(law)) = (self.twist, &self.shaft) {
            let bent = soft_threshold(x[at] + 0.5 * dt_s * x[at + 1], twist_sd, law.half_gap, law.half_gap);
            shaft = (law.stiffness * bent.mean + law.damping * bent.slope * x[at + 1], bent.slope);
            torque += shaft.0;
        }
        let dry = |sign: f64| if self.bristle.is_some() { 0.0 } else { self.friction.coulomb(sign) };
        let half = 0.5 * dt_s / self.inertia;
        let held = half * (level + dry(sign) + if self.spring.is_some() { 0.0 } else { step.level });
        // What bends over speed is taken at the speed in the middle of the substep.
        let sliding = w + half * (torque - viscous * w);
        let between = if sliding.abs() > held { sliding - held.copysign(sliding) } else { 0.0 };
        viscous += self.friction.quadratic_coefficient() * between.abs();
        let decay = viscous / self.inertia * dt_s;
        let kept = if decay > 0.0 { (-decay).exp() } else { 1.0 };
        let gain = if decay > 1e-9 { (1.0 - kept) / viscous } else { dt_s / self.inertia };
        let excess = self.friction.excess(between);
        if let Some(at) = self.bristle {
            let coulomb = 0.5 * (self.friction.coulomb(1.0) + self.friction.coulomb(-1.0));
            torque -= x[at] * (1.0 + excess / coulomb.max(f64::MIN_POSITIVE));
        } else {
            level += excess;
        }
        if let Some((_, at)) = self.spring {
            torque -= x[at];
        } else {
            level += step.level;
        }
        Free {
            speed: kept * w + gain * torque,
            gain,
            kept,
            up: gain * (level + dry(1.0)).max(0.0),
            down: gain * (level + dry(-1.0)).max(0.0),
            shaft,
            slope: self.position.slope(middle),
        }
    }

    /// The mean of the state at the end of a substep, for a belief whose free speed spreads by `speed_sd` and whose twist by
    /// `twist_sd`.
    #[inline]
    pub(crate) fn mean<const N: usize>(&self, x: &[f64; N], step: &Substep, speed_sd: f64, twist_sd: f64) -> [f64; N] {
        let free = self.free(x, step, twist_sd);
        let speed = soft_threshold(free.speed, speed_sd, free.up, free.down).mean;
        self.moved(x, step, &free, speed)
    }

    #[inline]
    fn moved<const N: usize>(&self, x: &[f64; N], step: &Substep, free: &Free, speed: f64) -> [f64; N] {
        let dt_s = step.dt_s;
        let mut next = *x;
        let travel = 0.5 * dt_s * (x[SPEED] + speed);
        (next[POSITION], next[SPEED]) = (x[POSITION] + travel, speed);
        if let (Some(at), Some(law)) = (self.twist, &self.shaft) {
            next[at + 1] = x[at + 1] - dt_s * law.per_load_inertia * free.shaft.0 - (speed - x[SPEED]);
            next[at] = x[at] + 0.5 * dt_s * (x[at + 1] + next[at + 1]);
        }
        if let Some(at) = self.bristle {
            next[at] = self.friction.bristle_after(travel.signum(), x[at], travel);
        }
        if let Some((stiffness, at)) = self.spring {
            next[at] = (x[at] + stiffness * travel).clamp(-step.level, step.level);
        }
        next
    }

    /// Keeps what hangs on the rotor where it is, seen from a rotor at `position` and `speed` instead of where `next` has it.
    pub(crate) fn carry<const N: usize>(&self, inside: &mut [f64; N], next: &[f64; N], position: f64, speed: f64) {
        *inside = *next;
        if let Some(at) = self.twist {
            inside[at] += next[POSITION] - position;
            inside[at + 1] += next[SPEED] - speed;
        }
    }

    /// Moves mean and covariance through a substep with torque noise and the rounding's change over the travel; returns what a
    /// linearised pass needs.
    #[inline]
    pub(crate) fn predict<const N: usize>(
        &self,
        x: &mut [f64; N],
        p: &mut [[f64; N]; N],
        step: &Substep,
        noise: &Noise,
        rounding: &Rounding,
    ) -> Linear<N> {
        let torque_variance = noise.torque_variance(step.dt_s);
        let twist_sd = self.twist.map_or(0.0, |at| p[at][at].max(0.0).sqrt());
        let free = self.free(x, step, twist_sd);
        let row = self.row(step, &free);
        let mut variance = free.gain * free.gain * torque_variance;
        for i in 0..N {
            for j in 0..N {
                variance += row[i] * p[i][j] * row[j];
            }
        }
        let speed_sd = variance.max(1e-300).sqrt();
        let speed = soft_threshold(free.speed, speed_sd, free.up, free.down);
        let (mut jacobian, push) = self.jacobian(x, step, &free, &row, &speed);
        let next = self.moved(x, step, &free, speed.mean);
        let kept = rounding.kept(next[POSITION] - x[POSITION]);
        jacobian[ROUNDING][ROUNDING] = kept;
        *x = next;
        x[ROUNDING] *= kept;
        spread(p, &jacobian);
        self.stir(p, step.dt_s, push[SPEED] * push[SPEED] * torque_variance + speed.rest);
        p[ROUNDING][ROUNDING] += (1.0 - kept * kept) * rounding.variance;
        Linear { jacobian, push, gain: free.gain, speed_sd, twist_sd }
    }

    /// Widens a covariance over a substep along a linearised path.
    pub(crate) fn widen<const N: usize>(&self, p: &mut [[f64; N]; N], linear: &Linear<N>, dt_s: f64, noise: &Noise) {
        spread(p, &linear.jacobian);
        self.stir(p, dt_s, linear.push[SPEED] * linear.push[SPEED] * noise.torque_variance(dt_s));
    }

    /// d free speed / d state.
    #[inline]
    fn row<const N: usize>(&self, step: &Substep, free: &Free) -> [f64; N] {
        let mut row = [0.0; N];
        let half_s = 0.5 * step.dt_s;
        row[POSITION] = free.gain * free.slope;
        row[SPEED] = free.kept + free.gain * free.slope * half_s;
        if let (Some(at), Some(law)) = (self.twist, &self.shaft) {
            row[at] = free.gain * law.stiffness * free.shaft.1;
            row[at + 1] = free.gain * free.shaft.1 * (law.stiffness * half_s + law.damping);
        }
        for at in self.bristle.into_iter().chain(self.spring.map(|(_, at)| at)) {
            row[at] = -free.gain;
        }
        row
    }

    /// d state at the end / d state at the start, and / d torque.
    // Over 40 lines: one block for each state.
    fn jacobian<const N: usize>(
        &self,
        x: &[f64; N],
        step: &Substep,
        free: &Free,
        row: &[f64; N],
        speed: &Thresholded,
    ) -> ([[f64; N]; N], [f64; N]) {
        let half_s = 0.5 * step.dt_s;
        let mut f = [[0.0; N]; N];
        for (i, line) in f.iter_mut().enumerate() {
            line[i] = 1.0;
        }
        for j in 0..N {
            f[SPEED][j] = speed.slope * row[j];
            f[POSITION][j] += half_s * f[SPEED][j];
        }
        f[POSITION][SPEED] += half_s;
        let mut push = [0.0; N];
        push[SPEED] = speed.slope * free.gain;
        push[POSITION] = half_s * push[SPEED];
        if let (Some(at), Some(law)) = (self.twist, &self.shaft) {
            let pull = step.dt_s * law.per_load_inertia * free.shaft.1;
            for j in 0..N {
                f[at + 1][j] -= f[SPEED][j];
            }
            f[at + 1][SPEED] += 1.0;
            f[at + 1][at] -= pull * law.stiffness;
            f[at + 1][at + 1] -= pull * (law.stiffness * half_s + law.damping);
            for j in 0..N {
                f[at][j] += half_s * f[at + 1][j];
            }
            f[at][at + 1] += half_s;
            (push[at], push[at + 1]) = (-push[POSITION], -push[SPEED]);
        }
        let travel = half_s * (x[SPEED] + speed.mean);
        let mut follows = |at: usize, kept: f64, per_travel: f64| {
            for j in 0..N {
                let moved = f[POSITION][j] - f64::from(j == POSITION);
                f[at][j] = per_travel * moved + if j == at { kept } else { 0.0 };
            }
            push[at] = per_travel * push[POSITION];
        };
        if let (Some(at), Some(stiffness)) = (self.bristle, self.friction.stiffness()) {
            let sign = travel.signum();
            let level = self.friction.coulomb(sign).max(f64::MIN_POSITIVE);
            let kept = (-stiffness * travel.abs() / level).exp();
            follows(at, kept, stiffness * kept * (1.0 - sign * x[at] / level));
        }
        if let Some((stiffness, at)) = self.spring {
            let inside = f64::from((x[at] + stiffness * travel).abs() < step.level);
            follows(at, inside, inside * stiffness);
        }
        (f, push)
    }

    /// Adds a speed noise of variance `white` with what it moves within the substep.
    #[inline]
    fn stir<const N: usize>(&self, p: &mut [[f64; N]; N], dt_s: f64, white: f64) {
        let mut by = [0.0; N];
        (by[POSITION], by[SPEED]) = (0.5 * dt_s, 1.0);
        if let Some(at) = self.twist {
            (by[at], by[at + 1]) = (-0.5 * dt_s, -1.0);
        }
        for i in 0..N {
            for j in 0..N {
                p[i][j] += white * by[i] * by[j];
            }
        }
    }
}

/// What a linearised pass needs of a substep.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Linear<const N: usize> {
    pub(crate) jacobian: [[f64; N]; N],
    /// Response of the state to a torque of one.
    pub(crate) push: [f64; N],
    /// Response of the speed to a torque of one, were there no dry friction.
    pub(crate) gain: f64,
    pub(crate) speed_sd: f64,
    pub(crate) twist_sd: f64,
}

/// P = F P F'.
#[inline]
fn spread<const N: usize>(p: &mut [[f64; N]; N], f: &[[f64; N]; N]) {
    let mut half = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..N {
            let mut sum = 0.0;
            for k in 0..N {
                sum += f[i][k] * p[k][j];
            }
            half[i][j] = sum;
        }
    }
    for i in 0..N {
        for j in 0..=i {
            let mut sum = 0.0;
            for k in 0..N {
                sum += half[i][k] * f[j][k];
            }
            p[i][j] = sum;
            p[j][i] = sum;
        }
    }
}
