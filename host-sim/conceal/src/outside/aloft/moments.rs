//! What a drive without torque lets in, what comes and goes by itself, and tones that a motion starts.

use std::f64::consts::TAU;

use super::super::beyond::scatter;
use super::super::{Hidden, Rub, Seen, ramp};

/// A drive that shorts its windings where hardly any torque is asked: the motor brakes itself as a generator then (Mohan, Undeland and
/// Robbins, Power Electronics, 2003: dynamic braking); viscous coefficient, torque.
pub(in crate::outside) struct ShortedIdle(pub(in crate::outside) [f64; 2]);

impl Hidden for ShortedIdle {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let [viscous, torque] = self.0;
        Rub { viscous: viscous * ramp(torque - seen.drive.abs(), 0.2 * torque), ..Rub::NONE }
    }
}

/// A holding brake that the drive closes once it has asked for little torque for a time, and opens again as late (IEC 61800-5-2: control of
/// brakes); level, torque, time.
pub(in crate::outside) struct HoldingBrake {
    level: f64,
    torque: f64,
    time_s: f64,
    /// Time it has been idle, in those of closing.
    idle: f64,
    closes: bool,
    closed: f64,
}

impl HoldingBrake {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { level: v[0], torque: v[1], time_s: v[2], idle: 0.0, closes: false, closed: 0.0 }
    }
}

/// Time in which the shoes move over that which the drive waits, 1.
const SHOES: f64 = 0.2;

impl Hidden for HoldingBrake {
    fn friction(&mut self, seen: &Seen) -> Rub {
        let waits = seen.step_s / self.time_s;
        let idles = if seen.drive.abs() < self.torque { waits } else { -waits };
        self.idle = (self.idle + idles).clamp(0.0, 1.0);
        self.closes = if self.closes { self.idle > 0.0 } else { self.idle >= 1.0 };
        let wanted = f64::from(u8::from(self.closes));
        self.closed += seen.share_of_lag(SHOES * self.time_s) * (wanted - self.closed);
        Rub::level(self.level * self.closed)
    }
}

/// Share of a while in which what comes and goes changes over, 1.
const CHANGES: f64 = 0.1;

/// A hose on the air of a neighbour who turns it on and off: it pushes one way or the other for a while, and nobody knows before which
/// (Rice, Bell Syst. Tech. J. 23 (1944) 282: random telegraph signals); level, while, pattern of this recording.
pub(in crate::outside) struct Telegraph(pub(in crate::outside) [f64; 3]);

impl Hidden for Telegraph {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let [level, while_s, pattern] = self.0;
        let whiles = (seen.t_s + 0.5 * seen.step_s) / while_s + pattern / TAU;
        let side = |place: f64| if scatter(place, pattern) < 0.5 { -1.0 } else { 1.0 };
        let [own, next] = [side(whiles.floor()), side(whiles.floor() + 1.0)];
        let over = ramp(whiles - whiles.floor() - 1.0 + 0.5 * CHANGES, 0.5 * CHANGES);
        level * (own + over * (next - own))
    }
}

/// A cylinder of air that balances a weight, leaks, and is filled up by a switch of two pressures (Beater, Pneumatic Drives, 2007); level at
/// either, time between, phase of this recording.
pub(in crate::outside) struct ToppedUp(pub(in crate::outside) [f64; 3]);

impl Hidden for ToppedUp {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let [level, between_s, phase] = self.0;
        let within = ((seen.t_s + 0.5 * seen.step_s) / between_s + phase / TAU).rem_euclid(1.0);
        let leaks = within / (1.0 - CHANGES);
        let fills = (1.0 - within) / CHANGES;
        level * (1.0 - 2.0 * leaks.min(fills))
    }
}

/// Periods in which a tone grows and dies away, 1.
const GROWS: f64 = 1.0;
/// Strength below which a tone has died away, 1.
const FAINT: f64 = 0.01;

/// A tone of a fixed pitch, as long as something excites it.
struct Tone {
    level: f64,
    omega: f64,
    phase: f64,
    strength: f64,
}

impl Tone {
    /// Level, Hz.
    fn new(v: &[f64]) -> Self {
        Self { level: v[0], omega: TAU * v[1], phase: 0.0, strength: 0.0 }
    }

    fn after(&mut self, excited: bool, seen: &Seen) -> f64 {
        let wanted = f64::from(u8::from(excited));
        self.strength += seen.share_of_lag(TAU * GROWS / self.omega) * (wanted - self.strength);
        // What has died away begins anew.
        let begins = excited && self.strength < FAINT;
        self.phase = if begins { 0.0 } else { (self.phase + self.omega * seen.step_s) % TAU };
        self.level * self.strength * self.phase.sin()
    }
}

/// Speed below which a contact rests, over that up to which it squeals, 1.
const RESTS: f64 = 0.1;

/// A guide that squeals while it is slow, for its friction falls with the speed there (Ibrahim, Appl. Mech. Rev. 47 (1994) 209: squeal);
/// level, Hz, speed.
pub(in crate::outside) struct Squeals {
    tone: Tone,
    speed: f64,
}

impl Squeals {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { tone: Tone::new(v), speed: v[2] }
    }
}

impl Hidden for Squeals {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let slow = (RESTS * self.speed..self.speed).contains(&seen.speed.abs());
        self.tone.after(slow, seen)
    }
}

/// A tool that chatters where the axis drives it hard into the work (Altintas, Manufacturing Automation, 2012: chatter in cutting); level,
/// Hz, power.
pub(in crate::outside) struct CutChatters {
    tone: Tone,
    power_w: f64,
}

impl CutChatters {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { tone: Tone::new(v), power_w: v[2] }
    }
}

impl Hidden for CutChatters {
    fn torque(&mut self, seen: &Seen) -> f64 {
        self.tone.after(seen.drive * seen.speed > self.power_w, seen)
    }
}
