//! The covariance of the belief over a substep: Jacobian, noise, and what a linearised pass needs of them.

use super::super::gaussian::{Thresholded, dry_friction};
use super::super::noise::{Noise, Rounding};
use super::{BASE, Free, Laws, POSITION, ROUNDING, SPEED, Substep};

impl Laws {
    /// Moves mean and covariance through a substep with torque noise, whose memory, if it has one, is the last state, and the rounding's change over the travel; returns what a
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
        let colour = noise.colour.map(|colour| (colour, N - 1));
        let step = &colour.map_or(*step, |(_, at)| Substep { torque: step.torque + x[at], ..*step });
        let twist_sd = self.twist::<N>().map_or(0.0, |at| p[at][at].max(0.0).sqrt());
        let free = self.free(x, step, twist_sd);
        let mut row = self.row(x, step, &free);
        if let Some((_, at)) = colour {
            row[at] = free.gain;
        }
        let mut variance = free.gain * free.gain * torque_variance;
        for i in 0..N {
            variance += row[i] * dot(&p[i], &row);
        }
        let speed_sd = variance.max(1e-300).sqrt();
        let speed = dry_friction(free.speed, speed_sd, free.push(x), free.up, free.down);
        let (mut jacobian, push) = self.jacobian(x, step, &free, &row, &speed);
        let mut next = self.moved(x, step, &free, speed.mean);
        if let Some((colour, at)) = colour {
            jacobian[at][at] = colour.kept(step.dt_s);
            next[at] *= jacobian[at][at];
        }
        let kept = rounding.kept(next[POSITION] - x[POSITION]);
        jacobian[ROUNDING][ROUNDING] = kept;
        *x = next;
        x[ROUNDING] *= kept;
        spread(p, &jacobian, 0.5 * step.dt_s);
        self.stir(p, step.dt_s, push[SPEED] * push[SPEED] * torque_variance + speed.rest);
        if let Some((colour, at)) = colour {
            p[at][at] += colour.stirred(step.dt_s);
        }
        p[ROUNDING][ROUNDING] += (1.0 - kept * kept) * rounding.variance;
        Linear { jacobian, push, speed_sd, twist_sd }
    }

    /// Widens a covariance over a substep along a linearised path.
    pub(crate) fn widen<const N: usize>(&self, p: &mut [[f64; N]; N], linear: &Linear<N>, dt_s: f64, noise: &Noise) {
        spread(p, &linear.jacobian, 0.5 * dt_s);
        self.stir(p, dt_s, linear.push[SPEED] * linear.push[SPEED] * noise.torque_variance(dt_s));
        if let Some(colour) = noise.colour {
            p[N - 1][N - 1] += colour.stirred(dt_s);
        }
    }

    /// d free speed / d state.
    #[inline]
    fn row<const N: usize>(&self, x: &[f64; N], step: &Substep, free: &Free) -> [f64; N] {
        let mut row = [0.0; N];
        let half_s = 0.5 * step.dt_s;
        let middle = x[POSITION] + half_s * x[SPEED];
        let slope = self.position.slope(middle) + step.drive * self.ripple.slope(middle);
        row[POSITION] = free.gain * slope;
        row[SPEED] = free.kept + free.gain * slope * half_s;
        if let Some(at) = self.twist::<N>() {
            (row[at], row[at + 1]) = (free.gain * free.shaft.per_twist, free.gain * free.shaft.per_rate);
        }
        let bristle = self.bristle::<N>().map(|at| (at, free.bristle));
        let spring = self.spring::<N>().map(|(_, at)| (at, free.spring));
        for (at, (per_state, per_speed)) in bristle.into_iter().chain(spring) {
            row[at] = -free.gain * per_state;
            row[SPEED] -= free.gain * per_speed;
        }
        let (viscous, warm) = free.viscous;
        if let Some((warming, at)) = self.friction_warming::<N>() {
            row[at] = free.gain * warming.per_j * warm * x[SPEED];
        }
        if let Some((warming, at)) = self.fluid_warming::<N>() {
            // A lower level lets more speed through where the rotor slides, which the slope of the threshold says.
            let level = self.shares(x).1 * step.level;
            row[at] = free.gain * warming.per_j * (level.copysign(free.speed) + (viscous - warm) * x[SPEED]);
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
            let pushed = row[j] - if j == SPEED { free.kept } else { 0.0 };
            f[SPEED][j] = speed.slope * row[j] + speed.per_push * pushed;
            f[POSITION][j] += half_s * f[SPEED][j];
        }
        f[POSITION][SPEED] += half_s;
        let mut push = [0.0; N];
        push[SPEED] = (speed.slope + speed.per_push) * free.gain;
        push[POSITION] = half_s * push[SPEED];
        if let (Some(at), Some(law)) = (self.twist::<N>(), &self.shaft) {
            let per_torque = step.dt_s * law.per_load_inertia;
            // A change of the motor's speed is one of the rate, less what the damper takes of the shaft's torque.
            let follows = 1.0 - per_torque * free.shaft.per_change;
            for j in 0..N {
                f[at + 1][j] -= follows * f[SPEED][j];
            }
            f[at + 1][SPEED] += follows;
            f[at + 1][at] -= per_torque * free.shaft.per_twist;
            f[at + 1][at + 1] -= per_torque * free.shaft.per_rate;
            for j in 0..N {
                f[at][j] += half_s * f[at + 1][j];
            }
            f[at][at + 1] += half_s;
            (push[at], push[at + 1]) = (-follows * push[POSITION], -follows * push[SPEED]);
        }
        let travel = half_s * (x[SPEED] + speed.mean);
        let mut follows = |at: usize, kept: f64, per_travel: f64| {
            for j in 0..N {
                let moved = f[POSITION][j] - f64::from(j == POSITION);
                f[at][j] = per_travel * moved + if j == at { kept } else { 0.0 };
            }
            push[at] = per_travel * push[POSITION];
        };
        if let (Some(at), Some(stiffness)) = (self.bristle::<N>(), self.friction.stiffness()) {
            let sign = travel.signum();
            let level = self.friction.coulomb(sign).max(f64::MIN_POSITIVE);
            let kept = (-stiffness * travel.abs() / level).exp();
            follows(at, kept, stiffness * kept * (1.0 - sign * x[at] / level));
        }
        if let Some((stiffness, at)) = self.spring::<N>() {
            let inside = f64::from((x[at] + stiffness * travel).abs() < self.shares(x).1 * step.level);
            follows(at, inside, inside * stiffness);
        }
        for (warming, at) in self.friction_warming::<N>().into_iter().chain(self.fluid_warming::<N>()) {
            let (_, per_travel) = self.power(free, travel / step.dt_s);
            follows(at, warming.after(0.0, 0.0, step.dt_s).1, per_travel);
        }
        (f, push)
    }

    /// Adds a speed noise of variance `white` with what it moves within the substep.
    #[inline]
    fn stir<const N: usize>(&self, p: &mut [[f64; N]; N], dt_s: f64, white: f64) {
        let mut by = [0.0; N];
        (by[POSITION], by[SPEED]) = (0.5 * dt_s, 1.0);
        if let Some(at) = self.twist::<N>() {
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
    pub(crate) speed_sd: f64,
    pub(crate) twist_sd: f64,
}

#[inline]
fn dot<const N: usize>(one: &[f64; N], other: &[f64; N]) -> f64 {
    let mut sum = 0.0;
    for i in 0..N {
        sum += one[i] * other[i];
    }
    sum
}

/// P = F P F', for an F whose position follows the mean of the speeds at both ends, half a substep each, and whose rounding keeps to
/// itself.
#[inline]
fn spread<const N: usize>(p: &mut [[f64; N]; N], f: &[[f64; N]; N], half_s: f64) {
    let mut half = [[0.0; N]; N];
    // P is symmetric, so its rows are its columns.
    for j in 0..N {
        half[SPEED][j] = dot(&f[SPEED], &p[j]);
        half[POSITION][j] = p[POSITION][j] + half_s * (half[SPEED][j] + p[SPEED][j]);
        half[ROUNDING][j] = f[ROUNDING][ROUNDING] * p[ROUNDING][j];
        for i in BASE..N {
            half[i][j] = dot(&f[i], &p[j]);
        }
    }
    for i in 0..N {
        let of = &half[i];
        let speed = dot(of, &f[SPEED]);
        let position = of[POSITION] + half_s * (speed + of[SPEED]);
        let base = [position, speed, f[ROUNDING][ROUNDING] * of[ROUNDING]];
        for j in 0..=i {
            let value = if j < BASE { base[j] } else { dot(of, &f[j]) };
            (p[i][j], p[j][i]) = (value, value);
        }
    }
}
