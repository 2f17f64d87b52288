//! Along a kept pass: how the innovations respond to another machine, what torque is missing, and short simulations.

// Matrices are read by their indices, as the equations have them.
#![allow(clippy::needless_range_loop)]

use super::Noise;
use super::belief::{BASE, Linear, POSITION, ROUNDING, SPEED, Substep};
use super::filter::{Driven, HUBER, Innovations, MOST_STATES, Path, Prepared, Stored, StoredStep};
use super::grid::Grid;

impl Prepared {
    /// What each row's whitened innovation would change if, along the path of `base`, the machine were this one: the linear
    /// response to the difference of the two predictions in every substep.
    pub(crate) fn response(&self, base: &Self, path: &Path, driven: Driven<'_>) -> Vec<f64> {
        match path {
            Path::Three(stored) => self.respond(base, stored, driven),
            Path::Four(stored) => self.respond(base, stored, driven),
            Path::Five(stored) => self.respond(base, stored, driven),
            Path::Six(stored) => self.respond(base, stored, driven),
            Path::Most(stored) => self.respond(base, stored, driven),
        }
    }

    fn respond<const N: usize>(&self, base: &Self, stored: &Stored<N>, driven: Driven<'_>) -> Vec<f64> {
        if self.laws.states == base.laws.states {
            self.linear_pass(base, stored, driven, |_, step, substep| {
                self.laws.mean(&step.from, substep, step.linear.speed_sd, step.linear.twist_sd)
            })
        } else {
            let mut inside = [0.0; MOST_STATES];
            self.linear_pass(base, stored, driven, |_, step, substep| {
                inside[..BASE].copy_from_slice(&step.from[..BASE]);
                let next = self.laws.mean(&inside, substep, step.linear.speed_sd, 0.0);
                self.laws.carry(&mut inside, &next, step.to[POSITION], step.to[SPEED]);
                let mut moved = step.to;
                moved[..BASE].copy_from_slice(&next[..BASE]);
                moved
            })
        }
    }

    /// What each row's whitened innovation would change if a torque acted beside those of the machine: in the interval behind each
    /// row the one given for it, N m (N), felt as far as dry friction lets it.
    pub(crate) fn response_to_torque(&self, path: &Path, driven: Driven<'_>, torques: &[f64]) -> Vec<f64> {
        match path {
            Path::Three(stored) => self.respond_to_torque(stored, driven, torques),
            Path::Four(stored) => self.respond_to_torque(stored, driven, torques),
            Path::Five(stored) => self.respond_to_torque(stored, driven, torques),
            Path::Six(stored) => self.respond_to_torque(stored, driven, torques),
            Path::Most(stored) => self.respond_to_torque(stored, driven, torques),
        }
    }

    fn respond_to_torque<const N: usize>(&self, stored: &Stored<N>, driven: Driven<'_>, torques: &[f64]) -> Vec<f64> {
        self.linear_pass(self, stored, driven, |row, step, _| {
            let mut next = step.to;
            for i in 0..N {
                next[i] += step.linear.push[i] * torques[row];
            }
            next
        })
    }

    /// Windows of `horizon` rows, each simulated from the state that the pass estimated at its start; none across skipped rows.
    pub(crate) fn windows(&self, path: &Path, driven: Driven<'_>, noise: &Noise, horizon: usize) -> Vec<Window> {
        match path {
            Path::Three(stored) => self.simulated(stored, driven, noise, horizon),
            Path::Four(stored) => self.simulated(stored, driven, noise, horizon),
            Path::Five(stored) => self.simulated(stored, driven, noise, horizon),
            Path::Six(stored) => self.simulated(stored, driven, noise, horizon),
            Path::Most(stored) => self.simulated(stored, driven, noise, horizon),
        }
    }

    fn simulated<const N: usize>(
        &self,
        stored: &Stored<N>,
        driven: Driven<'_>,
        noise: &Noise,
        horizon: usize,
    ) -> Vec<Window> {
        let Driven { recorded, grid, acting, .. } = driven;
        let mut windows = Vec::new();
        let mut start = stored.rows.iter().position(|row| row.counted).unwrap_or(stored.rows.len());
        while start + horizon < stored.rows.len() {
            let end = start + horizon;
            if stored.rows[start..=end].iter().all(|row| row.counted) {
                let mut x = stored.steps[grid.first[start] as usize].from;
                let mut p = stored.rows[start].covariance;
                if let Some(colour) = noise.colour {
                    // A simulation knows nothing of the noise.
                    x[N - 1] = 0.0;
                    p.iter_mut().for_each(|line| line[N - 1] = 0.0);
                    p[N - 1] = [0.0; N];
                    p[N - 1][N - 1] = colour.sd * colour.sd;
                }
                let mut window = Window::new(start, horizon);
                for row in start..end {
                    for index in grid.first[row] as usize..grid.first[row + 1] as usize {
                        x = self.laws.mean(&x, &Substep::of(acting, index, grid.dt_s[row]), CERTAIN, CERTAIN);
                        self.laws.widen(&mut p, &stored.steps[index].linear, grid.dt_s[row], noise);
                    }
                    window.push(recorded.position[row + 1] - self.seen(x[POSITION]).0);
                    window.expected +=
                        p[POSITION][POSITION] + noise.sensor_sd * noise.sensor_sd + self.rounding.variance;
                }
                windows.push(window);
            }
            start = end;
        }
        windows
    }

    /// Sensitivity of half the squared whitened innovations to a torque in each substep, with the sign of the torque that is
    /// missing, less what dry friction holds of it; the adjoint of the linearised pass.
    pub(crate) fn missing_torque(&self, path: &Path, innovations: &Innovations, grid: &Grid) -> Vec<f64> {
        match path {
            Path::Three(stored) => adjoint(stored, innovations, grid),
            Path::Four(stored) => adjoint(stored, innovations, grid),
            Path::Five(stored) => adjoint(stored, innovations, grid),
            Path::Six(stored) => adjoint(stored, innovations, grid),
            Path::Most(stored) => adjoint(stored, innovations, grid),
        }
    }

    /// Sends the differences that `advance` shows, given a row and a step behind it, through the filter's own linearisation.
    fn linear_pass<const N: usize>(
        &self,
        base: &Self,
        stored: &Stored<N>,
        driven: Driven<'_>,
        mut advance: impl FnMut(usize, &StoredStep<N>, &Substep) -> [f64; N],
    ) -> Vec<f64> {
        let Driven { recorded, grid, acting, .. } = driven;
        let mut ds = [0.0; N];
        let mut column = Vec::with_capacity(recorded.rows());
        let bent = self.eccentricity != base.eccentricity;
        for (row, kept) in stored.rows.iter().enumerate() {
            let mut seen = kept.slope * ds[POSITION] + ds[ROUNDING];
            if bent {
                seen += self.seen(kept.position).0 - base.seen(kept.position).0;
            }
            column.push(if kept.counted { -seen * kept.per_sd } else { 0.0 });
            for i in 0..N {
                ds[i] -= kept.gain[i] * seen;
            }
            if row + 1 == stored.rows.len() {
                break;
            }
            for index in grid.first[row] as usize..grid.first[row + 1] as usize {
                let step = &stored.steps[index];
                let mut acted = Substep::of(acting, index, grid.dt_s[row]);
                if stored.coloured {
                    acted.torque += step.from[N - 1];
                }
                let mut next = advance(row, step, &acted);
                if stored.coloured {
                    next[N - 1] = step.to[N - 1];
                }
                let mut moved = [0.0; N];
                for i in 0..N {
                    let mut sum = if i == ROUNDING { 0.0 } else { next[i] - step.to[i] };
                    for j in 0..N {
                        sum += step.linear.jacobian[i][j] * ds[j];
                    }
                    moved[i] = sum;
                }
                ds = moved;
            }
        }
        column
    }
}

fn adjoint<const N: usize>(stored: &Stored<N>, innovations: &Innovations, grid: &Grid) -> Vec<f64> {
    let mut missing = vec![0.0; stored.steps.len()];
    let mut a = [0.0; N];
    for (row, kept) in stored.rows.iter().enumerate().rev() {
        if row + 1 < stored.rows.len() {
            for index in (grid.first[row] as usize..grid.first[row + 1] as usize).rev() {
                let Linear { jacobian: f, push, .. } = &stored.steps[index].linear;
                missing[index] = (0..N).map(|i| a[i] * push[i]).sum();
                let mut before = [0.0; N];
                for (j, before) in before.iter_mut().enumerate() {
                    *before = (0..N).map(|i| a[i] * f[i][j]).sum();
                }
                a = before;
            }
        }
        let pulled: f64 = (0..N).map(|i| a[i] * kept.gain[i]).sum();
        let own = if kept.counted { innovations.whitened[row].clamp(-HUBER, HUBER) * kept.per_sd } else { 0.0 };
        a[POSITION] += kept.slope * (own - pulled);
        a[ROUNDING] += own - pulled;
    }
    missing
}

/// One window.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Window {
    /// First row.
    pub(crate) start: usize,
    /// Number of rows.
    pub(crate) rows: usize,
    /// Sum of squares of recorded minus simulated position, rad^2 (m^2).
    pub(crate) squares: f64,
    /// The same as the noise and the estimated start let expect.
    pub(crate) expected: f64,
    /// Recorded minus simulated position of each row behind the first, rad (m); in single precision, for there are many.
    left: Vec<f32>,
}

impl Window {
    /// Of some rows from `start` on, none simulated yet.
    pub(crate) fn new(start: usize, rows: usize) -> Self {
        Self { start, rows, squares: 0.0, expected: 0.0, left: Vec::with_capacity(rows) }
    }

    /// Takes what is left of the next row.
    pub(crate) fn push(&mut self, left: f64) {
        self.squares += left * left;
        self.left.push(left as f32);
    }

    /// Sum of squares between its simulation and another one of the same rows, rad^2 (m^2).
    pub(crate) fn squares_between(&self, other: &Self) -> f64 {
        self.left.iter().zip(&other.left).map(|(own, other)| f64::from(own - other).powi(2)).sum()
    }
}

/// Standard deviation of a state that is simulated and not estimated: none, but for the closed forms' division.
pub(super) const CERTAIN: f64 = 1e-12;
