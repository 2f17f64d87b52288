//! Loads that waves run through, and belts that creep.

use super::super::{Hidden, Seen};

/// A line with mass and stiffness all along (rod, hose, long spring): the axis sends waves into it, and they come back from its far end
/// after twice the time of transit, a little rounded. In impedances the torque on it is Z (sent - back), and the speed is sent + back.
struct Line {
    transit_s: f64,
    /// Time constant of the rounding over the time of transit, 1.
    rounding: f64,
    sent: Vec<f64>,
    at: usize,
    back: f64,
}

impl Line {
    fn new(transit_s: f64, rounding: f64) -> Self {
        Self { transit_s, rounding, sent: Vec::new(), at: 0, back: 0.0 }
    }

    /// Torque over impedance; the wave comes back with the same sign from a free end (1), with the other from a held one (-1).
    fn pass(&mut self, seen: &Seen, end: f64) -> f64 {
        if self.sent.is_empty() {
            self.sent = vec![0.0; ((2.0 * self.transit_s / seen.step_s).round() as usize).max(1)];
        }
        let returns = seen.share_of_lag(self.rounding * self.transit_s);
        self.back += returns * (end * self.sent[self.at] - self.back);
        let sent = seen.speed - self.back;
        self.sent[self.at] = sent;
        self.at = (self.at + 1) % self.sent.len();
        sent - self.back
    }
}

/// A share of the inertia that is a long rod with a free end.
pub(in crate::outside) struct FreeLine {
    share: f64,
    impedance: f64,
    line: Line,
}

impl FreeLine {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        let [share, transit_s, rounding, inertia] = [v[0], v[1], v[2], v[3]];
        // Slow motion finds the inertia Z (t + r t / 2).
        let impedance = share * inertia / (transit_s * (1.0 + 0.5 * rounding));
        Self { share, impedance, line: Line::new(transit_s, rounding) }
    }
}

impl Hidden for FreeLine {
    fn torque(&mut self, seen: &Seen) -> f64 {
        -self.impedance * self.line.pass(seen, 1.0)
    }

    fn inertia(&self, _: &Seen) -> f64 {
        1.0 - self.share
    }
}

/// A long spring or hose with mass, held at its far end.
pub(in crate::outside) struct HeldLine {
    impedance: f64,
    line: Line,
}

impl HeldLine {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        let [stiffness, transit_s, rounding] = [v[0], v[1], v[2]];
        // Slow motion finds the stiffness Z / (t + r t / 2).
        Self { impedance: stiffness * transit_s * (1.0 + 0.5 * rounding), line: Line::new(transit_s, rounding) }
    }
}

impl Hidden for HeldLine {
    fn torque(&mut self, seen: &Seen) -> f64 {
        -self.impedance * self.line.pass(seen, -1.0)
    }
}

/// A belt with a seam: it creeps on its pulleys as it carries torque (Reynolds, 1874), so that the seam's place on the axis moves.
pub(in crate::outside) struct CreepingBelt {
    amplitude: f64,
    order: f64,
    phase: f64,
    /// rad or m for each J.
    per_work: f64,
    crept: f64,
}

impl CreepingBelt {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { amplitude: v[0], order: v[1], phase: v[2], per_work: v[3], crept: 0.0 }
    }
}

impl Hidden for CreepingBelt {
    fn torque(&mut self, seen: &Seen) -> f64 {
        self.crept += self.per_work * seen.step_s * seen.drive * seen.speed;
        self.amplitude * (self.order * (seen.position - self.crept) + self.phase).sin()
    }
}
