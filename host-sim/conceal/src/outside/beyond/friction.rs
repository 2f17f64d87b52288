//! Friction with states, with the power and with how the axis gains speed.

use super::super::unseen::Swing;
use super::super::{Hidden, Rub, Seen};
use super::{Gain, TwoStates, Way, scatter};

/// Gears in mixed lubrication: teeth rub with the load, and the less the better the speed carries a film between them (Bittencourt and
/// Gunnarsson, J. Dyn. Sys. Meas. Control 134 (2012) 051012: friction of a robot joint over load and speed); share, speed.
pub(in crate::outside) struct GearFilm(pub(in crate::outside) [f64; 2]);

impl Hidden for GearFilm {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let [share, speed] = self.0;
        Rub::level(share * seen.drive.abs() / (1.0 + (seen.speed / speed).powi(2)))
    }
}

/// Contacts that flash: where the power is high their tips are hot at once and shear more easily (Archard, Wear 2 (1959) 438: temperature of
/// rubbing surfaces). What is nominal is half as hot; share, power.
pub(in crate::outside) struct FlashHeat(pub(in crate::outside) [f64; 2]);

impl Hidden for FlashHeat {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let [share, power_w] = self.0;
        let hot = (seen.drive * seen.speed).abs() / power_w;
        Rub { share: 1.0 + share * (0.5 - hot / (1.0 + hot)), ..Rub::NONE }
    }
}

/// A bearing that lifts off at a speed, and touches down only at a much lower one (as foil bearings do: Heshmat, J. Tribol. 116 (1994) 287).
/// What is nominal is the mean of both.
pub(in crate::outside) struct LiftsOff {
    share: f64,
    lifted: TwoStates,
}

impl LiftsOff {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], lifted: TwoStates::new(v[1], 0.05, v[2]) }
    }
}

impl Hidden for LiftsOff {
    fn friction(&mut self, seen: &Seen) -> Rub {
        Rub { share: 1.0 + self.share * (0.5 - self.lifted.after(seen)), ..Rub::NONE }
    }
}

/// A carriage whose mass is beside its guide: gaining speed one way it twists against it and rubs more, the other way it is relieved (Slocum,
/// Precision Machine Design, 1992: loads of carriages).
pub(in crate::outside) struct MassBeside {
    share: f64,
    inertia: f64,
    gain: Gain,
}

impl MassBeside {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], inertia: v[1], gain: Gain::new(v[2]) }
    }
}

impl Hidden for MassBeside {
    fn friction(&mut self, seen: &Seen) -> Rub {
        Rub::level(self.share * self.inertia * self.gain.after(seen))
    }
}

/// A reel with a brake that inertia pulls in: it closes where the axis gains speed too fast, and opens as soon as it loses some (as in belts
/// of cars and in fall arresters).
pub(in crate::outside) struct InertiaBrake {
    level: f64,
    acceleration: f64,
    time_s: f64,
    gain: Gain,
    pulled: bool,
    closed: f64,
}

impl InertiaBrake {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        let [level, acceleration, time_s] = [v[0], v[1], v[2]];
        Self { level, acceleration, time_s, gain: Gain::new(time_s), pulled: false, closed: 0.0 }
    }
}

impl Hidden for InertiaBrake {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let gains = self.gain.after(seen) * seen.speed.signum();
        self.pulled = gains > if self.pulled { 0.0 } else { self.acceleration };
        self.closed += seen.share_of_lag(self.time_s) * (f64::from(u8::from(self.pulled)) - self.closed);
        Rub::level(self.level * self.closed)
    }
}

/// A guide that waves of its track excite: what presses on it rings, and the friction with it, most where the speed meets the resonance
/// (Hess and Soom, J. Tribol. 113 (1991) 80: normal vibrations and friction).
pub(in crate::outside) struct Chatter {
    level: f64,
    order: f64,
    phase: f64,
    pressed: Swing,
}

impl Chatter {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { level: v[0], order: v[1], phase: v[2], pressed: Swing::new(v[3], v[4]) }
    }
}

impl Hidden for Chatter {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let at_start = self.phase.sin();
        let wave = (self.order * seen.position + self.phase).sin() - at_start;
        Rub::level(self.level * (at_start + self.pressed.pass(wave, seen.step_s)[0]))
    }
}

/// Chips that get into a guide: over a stretch of the way here and there, nobody knows where before, it rubs more (Hutchings and Shipway,
/// Tribology, 2017: wear by hard particles); level, way, pattern of this recording.
pub(in crate::outside) struct Debris {
    level: f64,
    pattern: f64,
    way: Way,
}

/// Share of the stretches that have a chip, 1.
const CHIPS: f64 = 0.2;

impl Debris {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { level: v[0], pattern: v[2], way: Way::new(v[1]) }
    }
}

impl Hidden for Debris {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let (stretch, within) = self.way.after(seen);
        let chip = scatter(stretch, self.pattern) < CHIPS;
        Rub::level(if chip { self.level * (std::f64::consts::PI * within).sin().powi(2) } else { 0.0 })
    }
}
