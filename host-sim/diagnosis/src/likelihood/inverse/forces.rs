//! The force laws along a motion that is given.

use crate::likelihood::along::CERTAIN;
use crate::likelihood::belief::{Laws, POSITION, SPEED, Substep};
use crate::likelihood::filter::MOST_STATES;

/// What the machine remembers of its motion.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Memory {
    bristle: f64,
    twist: f64,
    twist_rate: f64,
    /// In viscous friction, J.
    heat_j: f64,
}

/// One interval of a given motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Interval {
    pub(super) dt_s: f64,
    /// In its middle, rad (m).
    pub(super) position: f64,
    /// In its middle, rad/s (m/s).
    pub(super) speed: f64,
    /// Of the speed over it, rad/s (m/s).
    pub(super) change: f64,
    /// Probability that it moves the way the speed says, less that of the other way, 0 to 1.
    pub(super) slides: f64,
    /// Acting on the rotor, N m (N).
    pub(super) torque: f64,
    /// Of that, the drive's before its ripple, N m (N).
    pub(super) drive: f64,
}

/// Substeps of a shaft's oscillation: ten a radian ...
const PER_RADIAN: f64 = 10.0;
/// ... and no more than this many an interval.
const MOST: f64 = 64.0;

impl Laws {
    pub(super) fn rotor_inertia(&self) -> f64 {
        self.inertia
    }

    /// What is left of the torque for the inertia, N m (N). Dry friction of a rotor that slides acts against the motion; that of
    /// one that rests takes what it can.
    pub(super) fn left(&self, memory: &mut Memory, along: &Interval) -> f64 {
        let Interval { dt_s, position, speed, change, slides, torque, drive } = *along;
        let sign = if speed < 0.0 { -1.0 } else { 1.0 };
        let rippled = drive * self.ripple.gain(position);
        let load = self.friction.of_load(rippled);
        let share = self.friction_warming.map_or(1.0, |(warming, _)| warming.share(memory.heat_j));
        let smooth = share * self.friction.viscous(sign) + self.friction.quadratic_coefficient() * speed.abs();
        let excess = self.friction.excess(speed) + load;
        if let Some((warming, _)) = self.friction_warming {
            let dry = slides * (self.friction.coulomb(sign) + excess);
            let power_w = (smooth * speed.abs() + dry) * speed.abs();
            (memory.heat_j, _) = warming.after(memory.heat_j, power_w, dt_s);
        }
        let mut left = torque + (rippled - drive) + self.position.torque(position) - smooth * speed
            + self.shaft_torque(memory, dt_s, change);
        if self.bristle.is_some() {
            let before = memory.bristle;
            memory.bristle = self.friction.bristle_after(speed.signum(), before, speed * dt_s);
            let mean_level = 0.5 * (self.friction.coulomb(1.0) + self.friction.coulomb(-1.0));
            return left - 0.5 * (before + memory.bristle) * (1.0 + excess / mean_level.max(f64::MIN_POSITIVE));
        }
        left -= slides * sign * (self.friction.coulomb(sign) + excess);
        let held = (1.0 - slides) * (self.friction.coulomb(left) + excess);
        left - left.clamp(-held.max(0.0), held.max(0.0))
    }

    /// Mean torque of the shaft on a motor whose speed changes by `change`, N m (N).
    fn shaft_torque(&self, memory: &mut Memory, dt_s: f64, change: f64) -> f64 {
        let Some(law) = &self.shaft else { return 0.0 };
        let resonance_rad_s = (law.stiffness * (law.per_load_inertia + self.inertia.recip())).sqrt();
        let steps = (dt_s * resonance_rad_s * PER_RADIAN).ceil().clamp(1.0, MOST);
        let (step_s, mut sum) = (dt_s / steps, 0.0);
        for _ in 0..steps as usize {
            let torque = law.torque_at(memory.twist, memory.twist_rate);
            memory.twist_rate -= step_s * law.per_load_inertia * torque + change / steps;
            memory.twist += step_s * memory.twist_rate;
            sum += torque;
        }
        sum / steps
    }

    /// A state at that position and speed, with nothing remembered.
    pub(super) fn state_at((position, speed): (f64, f64)) -> [f64; MOST_STATES] {
        let mut x = [0.0; MOST_STATES];
        (x[POSITION], x[SPEED]) = (position, speed);
        x
    }

    /// A state as it is remembered, of a rotor that is at another position and speed.
    pub(super) fn carried(&self, x: &[f64; MOST_STATES], (position, speed): (f64, f64)) -> [f64; MOST_STATES] {
        let mut inside = *x;
        self.carry(&mut inside, x, position, speed);
        (inside[POSITION], inside[SPEED]) = (position, speed);
        inside
    }

    /// The state behind a substep, known for certain.
    pub(super) fn certain(&self, x: &[f64; MOST_STATES], step: &Substep) -> [f64; MOST_STATES] {
        self.mean(x, step, CERTAIN, CERTAIN)
    }
}
