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

/// A rotor out of balance on a soft mount, whose bending lets the weight work against the turning: a torque with the square of the speed
/// at one order of the angle.
pub(super) struct Whirl(pub(super) [f64; 3]);

impl Hidden for Whirl {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let [coefficient, order, phase] = self.0;
        coefficient * seen.speed * seen.speed * (order * seen.position + phase).sin()
    }
}

/// Weights on springs that fly out with the speed: the momentum is J (1 + share x / (1 + x)) w with x the square of speed over theirs.
pub(super) struct Governor(pub(super) [f64; 2]);

impl Hidden for Governor {
    fn inertia(&self, seen: &Seen) -> f64 {
        let [share, speed] = self.0;
        let x = (seen.speed / speed).powi(2);
        // The slope of the momentum over the speed.
        1.0 + share * x * (3.0 + x) / (1.0 + x).powi(2)
    }
}

/// A liquid inside, dragged along by turbulent shear with the square of the difference of speeds.
pub(super) struct Fill {
    coefficient: f64,
    inertia: f64,
    speed: f64,
}

impl Fill {
    pub(super) fn new(v: &[f64]) -> Self {
        Self { coefficient: v[0], inertia: v[1], speed: 0.0 }
    }
}

impl Hidden for Fill {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let slip = seen.speed - self.speed;
        let torque = self.coefficient * slip * slip.abs();
        self.speed += seen.step_s * torque / self.inertia;
        -torque
    }
}

/// A constant push that comes as the machine warms up: a belt that tightens over its pulleys.
pub(super) struct Grows(pub(super) [f64; 2]);

impl Hidden for Grows {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let [torque, time_s] = self.0;
        -torque * (-seen.t_s / time_s).exp_m1()
    }
}

/// A hose or cable that cools and stiffens: a spring that grows with the time.
pub(super) struct Hose(pub(super) f64);

impl Hidden for Hose {
    fn torque(&mut self, seen: &Seen) -> f64 {
        -self.0 * seen.t_s * seen.position
    }
}
