//! Loads that are more than an inertia on one shaft.

use std::f64::consts::TAU;

use super::{Hidden, Seen};

/// Two loads in a row behind two flexible shafts.
pub(super) struct TwoResonances {
    inertia: f64,
    hz: [f64; 2],
    damping_ratio: f64,
    /// Of each load over the whole inertia.
    share: f64,
    at: [f64; 2],
    speed: [f64; 2],
}

impl TwoResonances {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { share: v[0], hz: [v[1], v[2]], damping_ratio: v[3], inertia: v[4], at: [0.0; 2], speed: [0.0; 2] }
    }
}

impl Hidden for TwoResonances {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let load = self.share * self.inertia;
        let link = |index: usize, twist: f64, rate: f64| {
            let omega = TAU * self.hz[index];
            load * (omega * omega * twist + 2.0 * self.damping_ratio * omega * rate)
        };
        // Semi-implicit: angles at the middle of the step, as the rotor has its own.
        let half = 0.5 * seen.step_s;
        let middle = [0, 1].map(|k| self.at[k] + half * self.speed[k]);
        let first = link(0, seen.position - middle[0], seen.speed - self.speed[0]);
        let second = link(1, middle[0] - middle[1], self.speed[0] - self.speed[1]);
        let next = [self.speed[0] + seen.step_s * (first - second) / load, self.speed[1] + seen.step_s * second / load];
        self.at = [0, 1].map(|k| middle[k] + half * next[k]);
        self.speed = next;
        -first
    }

    fn inertia(&self, _: &Seen) -> f64 {
        1.0 - 2.0 * self.share
    }
}

/// A load behind a slipping clutch.
pub(super) struct Clutch {
    share: f64,
    level: f64,
    /// Difference of the speeds from which on it slips.
    creep: f64,
    inertia: f64,
    speed: f64,
}

impl Clutch {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { share: v[0], level: v[1], creep: v[2], inertia: v[3], speed: 0.0 }
    }
}

impl Hidden for Clutch {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let torque = self.level * ((seen.speed - self.speed) / self.creep).clamp(-1.0, 1.0);
        self.speed += seen.step_s * torque / (self.share * self.inertia);
        -torque
    }

    fn inertia(&self, _: &Seen) -> f64 {
        1.0 - self.share
    }
}

/// Inertia that changes over the angle, as that of a linkage.
pub(super) struct Linkage(pub(super) [f64; 4]);

impl Hidden for Linkage {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let [share, order, phase, inertia] = self.0;
        -0.5 * inertia * share * order * (order * seen.position + phase).cos() * seen.speed * seen.speed
    }

    fn inertia(&self, seen: &Seen) -> f64 {
        let [share, order, phase, _] = self.0;
        1.0 + share * (order * seen.position + phase).sin()
    }
}
