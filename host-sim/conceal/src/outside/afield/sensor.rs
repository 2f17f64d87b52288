//! Sensors whose stamps wander, and sensors that warm up. They are read once a control period.

use std::f64::consts::TAU;

use super::super::beyond::scatter;
use super::super::{Heat, Hidden};

/// A camera that reads its picture line by line: what is farther along the way is seen later than the stamp says, what is before the middle
/// sooner (Ait-Aider and others, Proc. ECCV 2006, part II, 56: rolling shutters); rows at the end of the way, way.
pub(in crate::outside) struct ScanLine {
    rows: f64,
    way: f64,
    last: f64,
}

impl ScanLine {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { rows: v[0], way: v[1], last: 0.0 }
    }
}

impl Hidden for ScanLine {
    fn measured(&mut self, position: f64) -> f64 {
        let moved = position - self.last;
        self.last = position;
        position - self.rows * (position / self.way).clamp(-2.0, 2.0) * moved
    }
}

/// A sensor on a network with two routes: for a while its values come at once, for a while late, and nobody knows before which (Nilsson,
/// Real-Time Control Systems with Delays, Lund, 1998); rows late, rows of a while, pattern of this recording.
pub(in crate::outside) struct TwoRoutes {
    rows: f64,
    while_rows: f64,
    pattern: f64,
    read: f64,
    last: f64,
}

impl TwoRoutes {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { rows: v[0], while_rows: v[1], pattern: v[2], read: 0.0, last: 0.0 }
    }
}

impl Hidden for TwoRoutes {
    fn measured(&mut self, position: f64) -> f64 {
        let moved = position - self.last;
        self.last = position;
        // The first while begins before the recording, as the clock of the network has nothing to do with it.
        let late = scatter((self.read / self.while_rows + self.pattern / TAU).floor(), self.pattern) < 0.5;
        self.read += 1.0;
        if late { position - self.rows * moved } else { position }
    }
}

/// What the losses of the motor warm: the square of the torque.
struct Warmed {
    heat: Heat,
    period_s: f64,
    torque: f64,
}

impl Warmed {
    /// Energy in the square of the torque times time, time of cooling, period.
    fn new(v: &[f64]) -> Self {
        Self { heat: Heat::new(v[0], v[1]), period_s: v[2], torque: 0.0 }
    }

    /// How warm, from 0 to 1.
    fn after(&mut self) -> f64 {
        self.heat.after(self.torque * self.torque, self.period_s)
    }
}

/// A scale on a part that the motor warms: it grows, and reads too little (Bryan, CIRP Annals 39 (1990) 645: thermal errors); share, energy,
/// time, period.
pub(in crate::outside) struct ScaleGrows {
    share: f64,
    warmed: Warmed,
}

impl ScaleGrows {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], warmed: Warmed::new(&v[1..]) }
    }
}

impl Hidden for ScaleGrows {
    fn feels(&mut self, torque: f64) {
        self.warmed.torque = torque;
    }

    fn measured(&mut self, position: f64) -> f64 {
        position * (1.0 - self.share * self.warmed.after())
    }
}

/// A bracket of the sensor beside the motor: it warms on one side, and bends away (Bryan, as above); way, energy, time, period.
pub(in crate::outside) struct BracketWarps {
    most: f64,
    warmed: Warmed,
}

impl BracketWarps {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { most: v[0], warmed: Warmed::new(&v[1..]) }
    }
}

impl Hidden for BracketWarps {
    fn feels(&mut self, torque: f64) {
        self.warmed.torque = torque;
    }

    fn measured(&mut self, position: f64) -> f64 {
        position + self.most * self.warmed.after()
    }
}
