//! Inverse dynamics: the motion is given and the torque column is the response, as where that column is a measurement.
//!
//! Where a drive and its delay are modelled, the torque is a command and the motion its response: then the filter judges. A
//! measured torque holds what no motion follows from (ripple, noise, the sensor's own filter), and control makes it follow the
//! motion: predicted motion then pulls every gain towards less motion per torque. The residual here is a torque,
//!
//! r = [sum over intervals of weight x (torque + position torque - drag along the smoothed motion) - J x mean acceleration] / gain,
//!
//! under test functions that stand side by side (Janot, Vandanjon, Gautier 2014; weak form without differentiated positions).

mod forces;
mod motion;

use super::acting::Acting;
use super::filter::{Driven, Innovations, MOST_STATES, Prepared, loss};
use super::grid::Grid;
use super::noise::Noise;
use crate::likelihood::along::Window;
use crate::likelihood::belief::{BASE, Laws, Substep};
use crate::recorded::Recorded;

use forces::{Interval, Memory};

pub use motion::Motion;

/// The residual torques of a recording under one machine, one for each test function, N m (N).
pub(crate) type Residual = Vec<f64>;

/// Mean over each row's interval of a torque that is given for each substep.
fn row_torques(torques: &[f64], grid: &Grid) -> Vec<f64> {
    (0..grid.dt_s.len())
        .map(|row| {
            let steps = grid.first[row] as usize..grid.first[row + 1] as usize;
            let many = steps.len().max(1) as f64;
            torques[steps].iter().sum::<f64>() / many
        })
        .collect()
}

impl Prepared {
    /// What torque is left along a motion.
    pub(crate) fn residual(&self, motion: &Motion, recorded: &Recorded, grid: &Grid, acting: &Acting) -> Residual {
        let net = self.net(
            motion,
            recorded,
            &row_torques(&acting.drive.torque, grid),
            &row_torques(&acting.drive.drive, grid),
        );
        let inertia = self.laws.rotor_inertia();
        let rotor = (!self.eccentricity.is_empty())
            .then(|| recorded.position.iter().map(|seen| self.rotor(*seen)).collect::<Vec<f64>>());
        let per_column = self.per_column(0.5 * motion.support_s());
        let of = |test: &motion::Test| {
            let force: f64 = test.force.iter().zip(&net[test.rows.start..]).map(|(weight, net)| weight * net).sum();
            let accelerates = rotor.as_ref().map_or(test.accelerates, |rotor| test.acceleration_of(rotor));
            (force - inertia * accelerates) / per_column
        };
        motion.tests.iter().map(of).collect()
    }

    /// What the column's noise grows by on its way to the torque that acts: as a density over the column, a machine that shrinks or
    /// smooths the torque must not gain by it. Undoing a filter of time constant tau grows white noise under a bump k by
    /// sqrt(1 + tau^2 int k'^2 / int k^2), and the bump (1 - (t/h)^2)^2 has a ratio of 3 / h^2.
    fn per_column(&self, half_s: f64) -> f64 {
        self.torque_gain * (1.0 + 3.0 * (self.torque_filter_s / half_s).powi(2)).sqrt()
    }

    /// Torque left of each interval beside the inertia's.
    fn net(&self, motion: &Motion, recorded: &Recorded, torques: &[f64], drives: &[f64]) -> Vec<f64> {
        let mut memory = Memory::default();
        (0..torques.len())
            .map(|row| {
                let dt_s = recorded.t_s[row + 1] - recorded.t_s[row];
                let speed = 0.5 * (motion.speed[row] + motion.speed[row + 1]);
                let along = Interval {
                    dt_s,
                    position: self.rotor(0.5 * (motion.position[row] + motion.position[row + 1])),
                    speed,
                    change: motion.speed[row + 1] - motion.speed[row],
                    slides: motion.slides[row],
                    torque: torques[row],
                    drive: drives[row],
                };
                self.laws.left(&mut memory, &along)
            })
            .collect()
    }

    /// Whitened residual torques, at the middle rows of their test functions; every other row counts nothing.
    pub(crate) fn whiten(
        &self,
        motion: &Motion,
        recorded: &Recorded,
        residual: &Residual,
        noise: &Noise,
    ) -> Innovations {
        let rows = recorded.rows();
        let mut found = Innovations {
            whitened: vec![0.0; rows],
            innovation: recorded.position.iter().zip(&motion.position).map(|(seen, smooth)| seen - smooth).collect(),
            log_likelihood: vec![0.0; rows],
            position: motion.position.clone(),
            speed: motion.speed.clone(),
            left_torque: vec![0.0; rows],
            counted: vec![false; rows],
        };
        for (test, &torque) in motion.tests.iter().zip(residual) {
            let sd = self.torque_sd(test, noise);
            let row = test.middle;
            found.whitened[row] = torque / sd;
            found.log_likelihood[row] = -sd.ln() - 0.5 * loss(torque / sd);
            found.counted[row] = true;
            found.left_torque[test.rows.clone()].fill(-torque);
        }
        found
    }

    /// The noise of a residual torque, N m (N).
    fn torque_sd(&self, test: &motion::Test, noise: &Noise) -> f64 {
        let inertia = self.laws.rotor_inertia();
        let sensor = (inertia * noise.sensor_sd).powi(2) * test.per_sensor;
        (noise.torque_density * test.per_density + sensor).max(f64::MIN_POSITIVE).sqrt()
    }

    /// The noise under which residual torques are likeliest, by golden sections of the logarithm of its density.
    pub(crate) fn likeliest_noise(&self, motion: &Motion, residual: &Residual) -> Noise {
        let squares: f64 = motion
            .tests
            .iter()
            .zip(residual)
            .map(|(test, torque)| torque * torque / test.per_density.max(f64::MIN_POSITIVE))
            .sum();
        let most = squares / residual.len().max(1) as f64;
        let with = |ln: f64| Noise::white(motion.sensor_sd, most.max(f64::MIN_POSITIVE) * ln.exp());
        let cost = |ln: f64| -> f64 {
            let noise = with(ln);
            let of = |(test, torque): (&motion::Test, &f64)| {
                let sd = self.torque_sd(test, &noise);
                sd.ln() + 0.5 * loss(torque / sd)
            };
            motion.tests.iter().zip(residual).map(of).sum()
        };
        // Wrong samples make the mean square too large, by as much as e^12; below e^-24 of it there is none.
        let (mut low, mut high) = (-24.0, 1.0);
        let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        while high - low > 1e-3 {
            let (left, right) = (high - ratio * (high - low), low + ratio * (high - low));
            if cost(left) <= cost(right) {
                high = right;
            } else {
                low = left;
            }
        }
        with(0.5 * (low + high))
    }

    /// The state at each row: position and speed of the smoothed motion, and what that motion has left in a shaft, a bristle or a heat.
    fn states_along(&self, motion: &Motion, driven: &Driven<'_>) -> Vec<[f64; MOST_STATES]> {
        let recorded = driven.recorded;
        let of_rotor = |row: usize| (self.rotor(motion.position[row]), motion.speed[row]);
        let mut states: Vec<[f64; MOST_STATES]> =
            (0..recorded.rows()).map(|row| Laws::state_at(of_rotor(row))).collect();
        if self.laws.states == BASE {
            return states;
        }
        for row in 0..recorded.rows().saturating_sub(1) {
            if recorded.after_gap[row + 1] {
                continue;
            }
            states[row + 1] = self.laws.carried(&self.behind_row(states[row], driven, row), of_rotor(row + 1));
        }
        states
    }

    /// The state behind the interval after a row.
    fn behind_row(&self, mut x: [f64; MOST_STATES], driven: &Driven<'_>, row: usize) -> [f64; MOST_STATES] {
        let Driven { grid, acting, .. } = driven;
        for index in grid.first[row] as usize..grid.first[row + 1] as usize {
            x = self.laws.certain(&x, &Substep::of(acting, index, grid.dt_s[row]));
        }
        x
    }

    /// Windows of `horizon` rows, each simulated from the smoothed motion at its start.
    pub(crate) fn windows_along(
        &self,
        motion: &Motion,
        driven: Driven<'_>,
        noise: &Noise,
        horizon: usize,
    ) -> Vec<Window> {
        let recorded = driven.recorded;
        let mut windows = Vec::new();
        let inertia = self.laws.rotor_inertia();
        let states = self.states_along(motion, &driven);
        let mut start = 0;
        while start + horizon < recorded.rows() {
            let end = start + horizon;
            let whole = (start..=end).all(|row| !recorded.skipped[row] && (row == start || !recorded.after_gap[row]));
            if whole {
                let mut x = states[start];
                let mut window = Window::new(start, horizon);
                for row in start..end {
                    x = self.behind_row(x, &driven, row);
                    window.push(recorded.position[row + 1] - self.seen(x[0]).0);
                    let t_s = recorded.t_s[row + 1] - recorded.t_s[start];
                    window.expected += noise.sensor_sd * noise.sensor_sd
                        + (motion.speed_sd * t_s).powi(2)
                        + noise.torque_density * t_s.powi(3) / (3.0 * inertia * inertia);
                }
                windows.push(window);
            }
            start = end;
        }
        windows
    }

    /// The rotor's position behind a measured one, by one step of the fixed-point iteration: eccentricities are small.
    fn rotor(&self, seen: f64) -> f64 {
        if self.eccentricity.is_empty() { seen } else { 2.0 * seen - self.seen(seen).0 }
    }

    /// What each row's whitened residual would change from a machine that left `base` to this one.
    pub(crate) fn difference(
        &self,
        base: &Innovations,
        motion: &Motion,
        recorded: &Recorded,
        residual: &Residual,
        noise: &Noise,
    ) -> Vec<f64> {
        let mut column = vec![0.0; recorded.rows()];
        for (test, torque) in motion.tests.iter().zip(residual) {
            column[test.middle] = torque / self.torque_sd(test, noise) - base.whitened[test.middle];
        }
        column
    }

    /// What each row's whitened residual would change if a torque acted beside those of the machine: in the interval behind each
    /// row the one given for it, N m (N).
    pub(crate) fn response_to_torque_along(
        &self,
        motion: &Motion,
        recorded: &Recorded,
        noise: &Noise,
        torques: &[f64],
    ) -> Vec<f64> {
        let mut column = vec![0.0; recorded.rows()];
        let per_column = self.per_column(0.5 * motion.support_s());
        for test in &motion.tests {
            let felt: f64 = test.force.iter().zip(test.rows.clone()).map(|(weight, row)| weight * torques[row]).sum();
            column[test.middle] = felt / (per_column * self.torque_sd(test, noise));
        }
        column
    }

    /// Sensitivity of half the squared whitened residuals to a torque in each substep, with the sign of the torque that is
    /// missing.
    pub(crate) fn missing_along(
        &self,
        motion: &Motion,
        grid: &Grid,
        innovations: &Innovations,
        noise: &Noise,
    ) -> Vec<f64> {
        let mut missing = vec![0.0; grid.substeps()];
        for test in &motion.tests {
            let per_torque = innovations.whitened[test.middle] / self.torque_sd(test, noise);
            for (weight, row) in test.force.iter().zip(test.rows.clone()) {
                let steps = grid.first[row] as usize..grid.first[row + 1] as usize;
                let share = (steps.len().max(1) as f64).recip();
                // A torque that acted and is not in the column leaves less than none.
                missing[steps].iter_mut().for_each(|value| *value -= weight * per_torque * share);
            }
        }
        missing
    }
}
