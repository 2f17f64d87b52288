//! Friction that keeps a record of the track, of the flow of power or of a phase that runs away.

use super::super::{Hidden, Rub, Seen};
use super::drive::wave;

/// A seal that a pulsing pump presses on more and less; level, Hz, phase.
pub(in crate::outside) struct PulsingSeal(pub(in crate::outside) [f64; 3]);

impl Hidden for PulsingSeal {
    fn friction(&mut self, seen: &Seen) -> Rub {
        Rub::level(self.0[0] * wave(&self.0, seen))
    }
}

/// A cage of balls that slips in its races: its angle, and where it rubs more and less, runs away from the shaft's with the way travelled.
pub(in crate::outside) struct SlippingCage {
    level: f64,
    order: f64,
    phase: f64,
    slip: f64,
}

impl SlippingCage {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { level: v[0], order: v[1], phase: v[2], slip: v[3] }
    }
}

impl Hidden for SlippingCage {
    fn friction(&mut self, seen: &Seen) -> Rub {
        self.phase += self.slip * seen.step_s * seen.speed.abs();
        Rub::level(self.level * (self.order * seen.position + self.phase).sin())
    }
}

/// Grease that the axis pushes up at the ends of its strokes and has to plough when it goes beyond them; it flows back in a time.
pub(in crate::outside) struct Ridges {
    level: f64,
    width: f64,
    time_s: f64,
    ends: [f64; 2],
}

impl Ridges {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { level: v[0], width: v[1], time_s: v[2], ends: [0.0; 2] }
    }
}

impl Hidden for Ridges {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let (at, flows) = (seen.position, seen.share_of_lag(self.time_s));
        let [low, high] = self.ends;
        self.ends = [low.min(at), high.max(at)].map(|end| end + flows * (at - end));
        let before = if seen.speed > 0.0 { self.ends[1] - at } else { at - self.ends[0] };
        Rub::level(self.level * (-before.max(0.0) / self.width).exp())
    }
}

/// Places of a track that [`Coat`] tells apart; beyond, it begins again.
const PLACES: usize = 64;

/// A coat of grease on the track that each pass wipes away where it passes, and that flows back in a time: a place is rough after it was
/// left alone, smooth while it is passed again and again (Lugt, Grease Lubrication in Rolling Bearings, 2013: channels and replenishment).
pub(in crate::outside) struct Coat {
    level: f64,
    passes: f64,
    place: f64,
    time_s: f64,
    /// Passes that each place still remembers, and of when, s.
    passed: [(f64, f64); PLACES],
}

impl Coat {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { level: v[0], passes: v[1], place: v[2], time_s: v[3], passed: [(0.0, 0.0); PLACES] }
    }
}

impl Hidden for Coat {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let at = (seen.position / self.place).rem_euclid(PLACES as f64);
        let (index, beyond) = ((at as usize).min(PLACES - 1), at.fract());
        let way = seen.step_s * seen.speed.abs() / self.place;
        let mut left = 0.0;
        for (index, share) in [(index, 1.0 - beyond), ((index + 1) % PLACES, beyond)] {
            let (passed, at_s) = &mut self.passed[index];
            *passed = *passed * ((*at_s - seen.t_s) / self.time_s).exp() + share * way;
            *at_s = seen.t_s;
            left += share * (-*passed / self.passes).exp();
        }
        Rub::level(self.level * left)
    }
}

/// A worm that locks: its teeth lose torque where the load drives the motor, and none the other way.
pub(in crate::outside) struct WormLocks(pub(in crate::outside) f64);

impl Hidden for WormLocks {
    fn friction(&mut self, seen: &Seen) -> Rub {
        Rub::level(if seen.drive * seen.speed < 0.0 { self.0 * seen.drive.abs() } else { 0.0 })
    }
}

/// A hoist's load brake (Weston): a screw that the load tightens as it drives and the motor loosens, each over a way.
pub(in crate::outside) struct LoadBrake {
    level: f64,
    way: f64,
    tight: f64,
}

impl LoadBrake {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { level: v[0], way: v[1], tight: 0.0 }
    }
}

impl Hidden for LoadBrake {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let driven = seen.drive * seen.speed < 0.0;
        let turns = seen.step_s * seen.speed.abs() / self.way;
        self.tight = (self.tight + if driven { turns } else { -turns }).clamp(0.0, 1.0);
        Rub::level(self.level * self.tight)
    }
}
