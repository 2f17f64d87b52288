//! Torques of converters that switch, and of motors whose iron takes part.

use std::f64::consts::TAU;

use super::super::{Hidden, Seen};

/// A thyristor converter takes a new current only where it fires, on the clock of the mains, and holds it until the next firing (Leonhard,
/// Control of Electrical Drives, 2001: line-commutated converters of DC drives).
pub(in crate::outside) struct MainsFiring {
    period_s: f64,
    /// Time constant of the rise after a firing over the period, 1.
    rounding: f64,
    phase: f64,
    fired: f64,
    held: f64,
    at: f64,
}

impl MainsFiring {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { period_s: v[0], rounding: v[1], phase: v[2], fired: f64::NEG_INFINITY, held: 0.0, at: 0.0 }
    }
}

impl Hidden for MainsFiring {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        if self.period_s <= seen.step_s {
            return torque;
        }
        let firing = (seen.t_s / self.period_s + self.phase / TAU).floor();
        if firing > self.fired {
            (self.fired, self.held) = (firing, torque);
        }
        self.at += seen.share_of_lag(self.rounding * self.period_s) * (self.held - self.at);
        self.at
    }
}

/// A pair of thyristor bridges, one for each sign of the current: between them comes a pause without any (Leonhard, as above: DC drives
/// without circulating current).
pub(in crate::outside) struct BridgePause {
    pause_s: f64,
    bridge: f64,
    waited_s: f64,
}

impl BridgePause {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { pause_s: v[0], bridge: 0.0, waited_s: 0.0 }
    }
}

impl Hidden for BridgePause {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        if torque * self.bridge > 0.0 || torque == 0.0 {
            self.waited_s = 0.0;
            return torque;
        }
        if self.bridge == 0.0 || self.waited_s >= self.pause_s {
            (self.bridge, self.waited_s) = (torque.signum(), 0.0);
            return torque;
        }
        // Of the step in which the pause ends the rest has current.
        let left_s = self.pause_s - self.waited_s;
        self.waited_s += seen.step_s;
        torque * (1.0 - left_s / seen.step_s).max(0.0)
    }
}

/// A rotor with poles that stand out, commutated a little off: a torque with the square of the current over the angle (Krause, Analysis of
/// Electric Machinery, 2013: reluctance torque of salient synchronous motors); amplitude, torque at which it is reached, order, phase.
pub(in crate::outside) struct Reluctance(pub(in crate::outside) [f64; 4]);

impl Hidden for Reluctance {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let [amplitude, full, order, phase] = self.0;
        torque + amplitude * (torque / full).powi(2) * (order * seen.position + phase).sin()
    }
}

/// Cogging that was taken out without current: the current saturates teeth and shifts it along the angle (Chu and Zhu, IEEE Trans. Magn. 49
/// (2013) 2982: cogging under load of motors with magnets); amplitude, torque for a shift by 1 rad, order, phase.
pub(in crate::outside) struct CoggingUnderLoad(pub(in crate::outside) [f64; 4]);

impl Hidden for CoggingUnderLoad {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let [amplitude, for_a_radian, order, phase] = self.0;
        let at = order * seen.position + phase;
        torque + amplitude * ((at + torque / for_a_radian).sin() - at.sin())
    }
}
