//! States inside the machine that no sensor shows: bristles, the fluid's spring, a load behind a shaft. They follow from
//! the recorded motion, so an observer driven along it knows about where they are at any row: near enough to begin a search
//! for the start of a window, not near enough to be that start, for the smoothed motion blurs impacts.

use plant::State;

use crate::effects::{Load, Physics};
use crate::screen::{Bounce, Motion, yield_level};

/// One recording as an observer runs along it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Observer<'a> {
    motion: &'a Motion,
}

impl<'a> Observer<'a> {
    /// Along a smoothed motion.
    pub(super) fn new(motion: &'a Motion) -> Self {
        Self { motion }
    }

    /// The states inside a machine at some rows, in order; position and speed are those of the motion.
    pub(super) fn states(&self, physics: &Physics, rows: &[usize]) -> Vec<State> {
        let motion = self.motion;
        let mut states: Vec<State> =
            rows.iter().map(|&row| State::new(motion.smooth[row], motion.speed[row])).collect();
        if physics.presliding.is_finite() {
            let forces = self.dry_bristle(physics);
            states.iter_mut().zip(rows).for_each(|(state, &row)| state.bristle_torque = forces[row]);
        }
        if physics.damper.as_ref().is_some_and(|damper| damper.preyield.is_finite())
            && let Some((damper, level)) = yield_level(physics, motion)
        {
            let forces = self.fluid_spring(damper.preyield, &level);
            states.iter_mut().zip(rows).for_each(|(state, &row)| state.spring_torque = forces[row]);
        }
        if let Some(load) = physics.load.as_ref().filter(|load| load.inertia_ratio > 0.0) {
            let twists = self.twists(load, physics.inertia);
            for (state, &row) in states.iter_mut().zip(rows) {
                (state.twist, state.twist_rate) = twists[row];
            }
        }
        states
    }

    /// Dahl's bristle at the rows, N m (N): over a way x it approaches its level as exp(-stiffness x / level).
    fn dry_bristle(&self, physics: &Physics) -> Vec<f64> {
        let mut force: f64 = 0.0;
        let mut forces = vec![0.0; self.motion.smooth.len()];
        for (cell, pair) in self.motion.smooth.windows(2).enumerate() {
            let way = pair[1] - pair[0];
            let level = (physics.coulomb + 0.5 * physics.asymmetry * way.signum()).max(1e-12);
            let target = level * way.signum();
            if way != 0.0 {
                force = target + (force - target) * (-physics.presliding * way.abs() / level).exp();
            }
            forces[cell + 1] = force;
        }
        forces
    }

    /// The fluid's spring at the rows, N m (N), limited by the torque of the acting field.
    fn fluid_spring(&self, stiffness: f64, level: &[f64]) -> Vec<f64> {
        let mut force: f64 = 0.0;
        let mut forces = vec![0.0; self.motion.smooth.len()];
        for (cell, pair) in self.motion.smooth.windows(2).enumerate() {
            let limit = level[cell].max(0.0);
            force = (force.clamp(-limit, limit) + stiffness * (pair[1] - pair[0])).clamp(-limit, limit);
            forces[cell + 1] = force;
        }
        forces
    }

    /// Twist (load minus motor), rad (m), and its rate at the rows. The load moves along at the first row and after gaps.
    fn twists(&self, load: &Load, inertia: f64) -> Vec<(f64, f64)> {
        let motion = self.motion;
        let mut law = Bounce::new(load, inertia);
        let (mut x, mut v) = (motion.smooth[0], motion.speed[0]);
        let mut twists = vec![(0.0, 0.0); motion.smooth.len()];
        for cell in 0..motion.cells() {
            let (q, w) = (motion.smooth[cell], motion.speed[cell]);
            let (next_q, next_w) = (motion.smooth[cell + 1], motion.speed[cell + 1]);
            if motion.broken[cell] {
                (x, v) = (next_q, next_w);
            } else {
                let span_s = motion.t_s[cell + 1] - motion.t_s[cell];
                (x, v) = law.along((x, v), (q, w), (next_w - w) / span_s, span_s);
            }
            twists[cell + 1] = (x - next_q, v - next_w);
        }
        twists
    }
}
