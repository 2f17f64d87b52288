//! Drives with states of their own: a flux, a store, a range, a contact.

use super::super::{Hidden, Seen, ramp};
use super::{Way, scatter};

/// Share of the flux that a drive keeps up without any torque, 1.
const LEAST_FLUX: f64 = 0.05;

/// An induction motor that saves energy: its flux is made to go with the root of the torque, and follows late by the rotor's time constant,
/// which the drive leaves out (Leonhard, Control of Electrical Drives, 2001: flux of induction motors).
pub(in crate::outside) struct FluxBuilds {
    time_s: f64,
    torque: f64,
    flux: f64,
}

impl FluxBuilds {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { time_s: v[0], torque: v[1], flux: LEAST_FLUX.sqrt() }
    }
}

impl Hidden for FluxBuilds {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let wanted = (LEAST_FLUX + torque.abs() / self.torque).sqrt();
        self.flux += seen.share_of_lag(self.time_s) * (wanted - self.flux);
        torque * self.flux / wanted
    }
}

/// A motor whose field is weakened beyond a speed: the drive takes more current for it at once, the flux itself goes and comes late
/// (Leonhard, as above: field weakening).
pub(in crate::outside) struct FluxReturnsLate {
    time_s: f64,
    speed: f64,
    flux: f64,
}

impl FluxReturnsLate {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { time_s: v[0], speed: v[1], flux: 1.0 }
    }
}

impl Hidden for FluxReturnsLate {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let wanted = 1.0 / (seen.speed.abs() / self.speed).max(1.0);
        self.flux += seen.share_of_lag(self.time_s) * (wanted - self.flux);
        torque * self.flux / wanted
    }
}

/// Mean square of the torque over that at full use above which a drive folds back, and below which it lets go again, 1.
const FOLDS: [f64; 2] = [1.2, 0.8];

/// A drive that folds back: once its model of the winding is hot it takes a share of what is beyond the rated torque away, until that has
/// cooled (I2t protection: IEC 61800-2, ratings of adjustable speed drives).
pub(in crate::outside) struct Foldback {
    share: f64,
    torque: f64,
    time_s: f64,
    heat: f64,
    folded: bool,
}

impl Foldback {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], torque: v[1], time_s: v[2], heat: 0.0, folded: false }
    }
}

impl Hidden for Foldback {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        self.folded = self.heat > FOLDS[usize::from(self.folded)];
        let beyond = torque - torque.clamp(-self.torque, self.torque);
        let acts = if self.folded { torque - self.share * beyond } else { torque };
        self.heat += seen.share_of_lag(self.time_s) * ((acts / self.torque).powi(2) - self.heat);
        acts
    }
}

/// A rectifier that takes no power back: what the axis brakes fills the capacitor of the bus, and from a voltage on the drive gives up
/// braking until driving has used the charge (Mohan, Undeland and Robbins, Power Electronics, 2003: braking of drives).
pub(in crate::outside) struct BusFills {
    share: f64,
    energy_j: f64,
    stored_j: f64,
}

/// Store beyond the first at which nothing more is braked, over that, 1.
const OVERFULL: f64 = 0.2;

impl BusFills {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], energy_j: v[1], stored_j: 0.0 }
    }
}

impl Hidden for BusFills {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let over = ((self.stored_j / self.energy_j - 1.0) / OVERFULL).clamp(0.0, 1.0);
        let brakes = torque * seen.speed < 0.0;
        let acts = if brakes { torque * (1.0 - self.share * over) } else { torque };
        let most = (1.0 + OVERFULL) * self.energy_j;
        self.stored_j = (self.stored_j - seen.step_s * acts * seen.speed).clamp(0.0, most);
        acts
    }
}

/// An amplifier with a fine and a coarse range whose gains differ, and that changes between them at torques apart (ranges of converters that
/// choose themselves: Horowitz and Hill, The Art of Electronics, 2015); difference, torque.
pub(in crate::outside) struct TwoRanges {
    difference: f64,
    torque: f64,
    coarse: bool,
}

impl TwoRanges {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { difference: v[0], torque: v[1], coarse: false }
    }
}

impl Hidden for TwoRanges {
    fn drive(&mut self, _: &Seen, torque: f64) -> f64 {
        self.coarse = torque.abs() > if self.coarse { 0.5 * self.torque } else { self.torque };
        if self.coarse { torque } else { torque * (1.0 + self.difference) }
    }
}

/// A spindle motor that reconnects its windings from star to delta at a speed, and back at a lower one: without torque until the contactors
/// have changed over (as spindles for low and high speed do).
pub(in crate::outside) struct Reconnects {
    pause_s: f64,
    speed: f64,
    fast: bool,
    left_s: f64,
}

impl Reconnects {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { pause_s: v[0], speed: v[1], fast: false, left_s: 0.0 }
    }
}

impl Hidden for Reconnects {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let fast = seen.speed.abs() > if self.fast { 0.7 * self.speed } else { self.speed };
        if fast != self.fast {
            (self.fast, self.left_s) = (fast, self.pause_s);
        }
        // Of the step in which the pause ends the rest has torque.
        let off = (self.left_s / seen.step_s).min(1.0);
        self.left_s = (self.left_s - seen.step_s).max(0.0);
        torque * (1.0 - off)
    }
}

/// Brushes that bounce on the commutator: over stretches of the way that nobody knows before, the contact carries less (Holm, Electric
/// Contacts, 1967); share, way, pattern of this recording.
pub(in crate::outside) struct BrushBounce {
    share: f64,
    pattern: f64,
    way: Way,
}

/// Share of the stretches in which they bounce, 1.
const BOUNCES: f64 = 0.3;

impl BrushBounce {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], pattern: v[2], way: Way::new(v[1]) }
    }
}

impl Hidden for BrushBounce {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let (stretch, within) = self.way.after(seen);
        let bounces = scatter(stretch, self.pattern) < BOUNCES;
        // Off and on again over a tenth of the stretch each.
        let off = ramp(0.5 - (within - 0.5).abs() - 0.05, 0.05);
        if bounces { torque * (1.0 - self.share * off) } else { torque }
    }
}
