//! Drives whose torque rises otherwise than it falls, whose valve sticks, and that hear their command late.

use std::f64::consts::TAU;

use super::super::beyond::scatter;
use super::super::{Hidden, Seen};

/// A coil whose current the bridge drives up at full voltage and leaves to a diode on its way down: it rises at once and falls late
/// (Horowitz and Hill, The Art of Electronics, 2015: inductive loads with diodes); time.
pub(in crate::outside) struct DiodeFalls {
    time_s: f64,
    at: f64,
}

impl DiodeFalls {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { time_s: v[0], at: 0.0 }
    }
}

impl Hidden for DiodeFalls {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let rises = torque * self.at >= 0.0 && torque.abs() >= self.at.abs();
        self.at = if rises { torque } else { self.at + seen.share_of_lag(self.time_s) * (torque - self.at) };
        self.at
    }
}

/// A motor that runs on air, which reaches its vanes through an orifice: the torque goes to a new value at a rate with the root of what is
/// missing (Beater, Pneumatic Drives, 2007: filling of volumes); time of filling by the torque, torque.
pub(in crate::outside) struct OrificeFills {
    time_s: f64,
    full: f64,
    at: f64,
}

impl OrificeFills {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { time_s: v[0], full: v[1], at: 0.0 }
    }
}

impl Hidden for OrificeFills {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let missing = (torque - self.at) / self.full;
        // Implicit in the flow, which is endlessly steep about nothing missing: root^2 + 2 flow root = |missing|.
        let flow = 0.5 * seen.step_s / self.time_s;
        let root = missing.abs() / (flow + (flow * flow + missing.abs()).sqrt()).max(f64::MIN_POSITIVE);
        self.at = torque - self.full * root * root * missing.signum();
        self.at
    }
}

/// A fast amplifier for small currents, and a slow one that brings what is beyond them (Ertl, Kolar and Zach, IEEE Trans. Ind. Electron. 44
/// (1997) 116: linear amplifiers that switched ones assist); time of the slow one, torque of the fast one.
pub(in crate::outside) struct BoosterLags {
    time_s: f64,
    small: f64,
    late: f64,
}

impl BoosterLags {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { time_s: v[0], small: v[1], late: 0.0 }
    }
}

impl Hidden for BoosterLags {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let fast = torque.clamp(-self.small, self.small);
        self.late += seen.share_of_lag(self.time_s) * (torque - fast - self.late);
        fast + self.late
    }
}

/// A valve whose spool sticks: it stays until what is asked is a band away, and then jumps there (Choudhury, Thornhill and Shah, Control Eng.
/// Practice 13 (2005) 641: stiction of valves); band.
pub(in crate::outside) struct SpoolSticks {
    band: f64,
    at: f64,
}

impl SpoolSticks {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { band: v[0], at: 0.0 }
    }
}

impl Hidden for SpoolSticks {
    fn drive(&mut self, _: &Seen, torque: f64) -> f64 {
        if (torque - self.at).abs() > self.band {
            self.at = torque;
        }
        self.at
    }
}

/// A spool about which dirt settles while it stands, and that washes it away as it moves: the longer it stood the farther it has to be asked
/// (Merritt, Hydraulic Control Systems, 1967: silting); most of the band, time, torque of a way that washes.
pub(in crate::outside) struct SpoolSilts {
    most: f64,
    time_s: f64,
    washes: f64,
    band: f64,
    at: f64,
}

impl SpoolSilts {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { most: v[0], time_s: v[1], washes: v[2], band: 0.0, at: 0.0 }
    }
}

impl Hidden for SpoolSilts {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        self.band += seen.share_of_lag(self.time_s) * (self.most - self.band);
        let way = (torque - self.at).abs();
        if way > self.band {
            self.band *= (-way / self.washes).exp();
            self.at = torque;
        }
        self.at
    }
}

/// Share of the whiles in which frames are lost, 1.
const LOST: f64 = 0.4;

/// Frames with the command that are lost on the network for a part of some whiles: the drive goes on with the last that came (Hespanha,
/// Naghshtabrizi and Xu, Proc. IEEE 95 (2007) 138: networks that drop packets); share of a while, while, pattern of this recording.
pub(in crate::outside) struct FramesLost {
    law: [f64; 3],
    held: f64,
}

impl FramesLost {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { law: [v[0], v[1], v[2]], held: 0.0 }
    }
}

impl Hidden for FramesLost {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let [share, while_s, pattern] = self.law;
        // The first while begins before the recording, as the network's clock has nothing to do with it.
        let whiles = seen.t_s / while_s + pattern / TAU;
        // Of the step in which the loss ends the rest has the new command.
        let left_s = (share - (whiles - whiles.floor())) * while_s;
        let lost = (left_s / seen.step_s).clamp(0.0, 1.0);
        if lost == 0.0 || scatter(whiles.floor(), pattern) >= LOST {
            self.held = torque;
        }
        self.held * lost + torque * (1.0 - lost)
    }
}

/// Longest delay of a busy loop over that at its speed, 1.
const MOST_BUSY: f64 = 4.0;

/// A processor that each pulse of the encoder interrupts: the faster the axis, the later the torque that it works out (Wittenmark, Nilsson
/// and Torngren, Proc. American Control Conference 1995, 2000: timing problems); delay at a speed, with whose square it goes; speed.
pub(in crate::outside) struct BusyLoop {
    delay_s: f64,
    speed: f64,
    asked: Vec<f64>,
    at: usize,
}

impl BusyLoop {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { delay_s: v[0], speed: v[1], asked: Vec::new(), at: 0 }
    }
}

impl Hidden for BusyLoop {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        if self.asked.is_empty() {
            self.asked = vec![0.0; (MOST_BUSY * self.delay_s / seen.step_s) as usize + 2];
        }
        let length = self.asked.len();
        self.at = (self.at + 1) % length;
        self.asked[self.at] = torque;
        let late = self.delay_s / seen.step_s * (seen.speed / self.speed).powi(2).min(MOST_BUSY);
        let ago = |steps: usize| self.asked[(self.at + length - steps) % length];
        let whole = (late as usize).min(length - 2);
        ago(whole) + (late - whole as f64).clamp(0.0, 1.0) * (ago(whole + 1) - ago(whole))
    }
}
