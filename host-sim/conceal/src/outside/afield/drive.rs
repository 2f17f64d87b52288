//! Drives that commutate late, whose iron or coil goes with the way, and that add torques of their own.

use std::f64::consts::PI;

use super::super::beyond::scatter;
use super::super::{Hidden, Seen, ramp};
use crate::delay::Play;

/// A drive that works out its current for the angle it read some time ago: at speed the current stands behind the magnets, and what acts is
/// the cosine of that (Bae and Sul, IEEE Trans. Ind. Appl. 39 (2003) 802: delays of digital current regulators); time over electrical angle.
pub(in crate::outside) struct AngleBehind(pub(in crate::outside) f64);

impl Hidden for AngleBehind {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        torque * (self.0 * seen.speed).cos()
    }
}

/// A brushless motor whose Hall sensors switch late by their hysteresis, either way: the ripple of the torque, which was taken out where the
/// teeth are, comes back and changes sides with the direction (Samoylenko, Han and Jatskevich, IEEE Trans. Energy Convers. 23 (2008) 752:
/// Hall sensors that are off); share, order, phase, half of the hysteresis.
pub(in crate::outside) struct HallHysteresis {
    share: f64,
    order: f64,
    phase: f64,
    switched: Play,
}

impl HallHysteresis {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], order: v[1], phase: v[2], switched: Play::new(v[3], 0.0) }
    }
}

impl Hidden for HallHysteresis {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let wave = |at: f64| (self.order * at + self.phase).sin();
        let switched = wave(self.switched.pass(seen.position));
        torque * (1.0 + self.share * (switched - wave(seen.position)))
    }
}

/// A coil that leaves the field of its magnets on either side: its force falls off with the distance (Klippel, J. Audio Eng. Soc. 54 (2006)
/// 907: force factor of voice coils over their way). What is nominal is half of that; share, middle, way.
pub(in crate::outside) struct ShortCoil(pub(in crate::outside) [f64; 3]);

impl Hidden for ShortCoil {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let [share, at, way] = self.0;
        let squared = ((seen.position - at) / way).powi(2);
        torque * (1.0 + share * (0.5 - squared / (1.0 + squared)))
    }
}

/// Share of a section over which it hands over to the next, 1.
const HANDS_OVER: f64 = 0.2;

/// A long stator of sections that are not wound alike: each has a force constant of its own (Nasar and Boldea, Linear Motion Electric
/// Machines, 1976: stators in sections); share, pitch, pattern.
pub(in crate::outside) struct StatorSections(pub(in crate::outside) [f64; 3]);

impl Hidden for StatorSections {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let [share, pitch, pattern] = self.0;
        let sections = seen.position / pitch + 0.5;
        let [own, next] = [0.0, 1.0].map(|further| scatter(sections.floor() + further, pattern));
        let over = ramp(sections - sections.floor() - 1.0 + 0.5 * HANDS_OVER, 0.5 * HANDS_OVER);
        torque * (1.0 + share * (2.0 * (own + over * (next - own)) - 1.0))
    }
}

/// Terms of the series of a sheet's flux; the rest of it is there at once.
const TERMS: usize = 6;

/// Iron that is not in thin sheets: eddy currents let the flux, and the torque with it, into it only by and by, fast near its surface and
/// slow in its middle (Stoll, The Analysis of Eddy Currents, 1974: a plate in a field along it); share, time of diffusion.
pub(in crate::outside) struct SolidIron {
    share: f64,
    time_s: f64,
    late: [f64; TERMS],
}

impl SolidIron {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], time_s: v[1], late: [0.0; TERMS] }
    }
}

impl Hidden for SolidIron {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        let mut missing = 0.0;
        for (index, late) in self.late.iter_mut().enumerate() {
            // tanh(q) / q of q^2 = s time is the sum of 2 / n^2 of lags time / n^2.
            let squared = ((index as f64 + 0.5) * PI).powi(2);
            *late += seen.share_of_lag(self.time_s / squared) * (torque - *late);
            missing += 2.0 / squared * (torque - *late);
        }
        torque - self.share * missing
    }
}

/// A drive with an observer of disturbances: what its torque did not bring to the inertia it takes for a disturbance, and adds a share of
/// it, late by a filter (Ohnishi, Shibata and Murakami, IEEE/ASME Trans. Mechatron. 1 (1996) 56); share, time, inertia.
pub(in crate::outside) struct Observer {
    share: f64,
    time_s: f64,
    inertia: f64,
    filtered: f64,
}

impl Observer {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], time_s: v[1], inertia: v[2], filtered: 0.0 }
    }
}

impl Hidden for Observer {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        // The filter of the gain of speed is that of the speed, without its slope.
        let of_speed = self.inertia / self.time_s * seen.speed;
        let acts = torque + self.share * (self.filtered - of_speed);
        self.filtered += seen.share_of_lag(self.time_s) * (acts + of_speed - self.filtered);
        acts
    }
}

/// A drive that was set up to repeat a stroke: it adds a share of what it gave a period before (Hara and others, IEEE Trans. Autom. Control
/// 33 (1988) 659: repetitive control); share, period.
pub(in crate::outside) struct Repeats {
    share: f64,
    period_s: f64,
    given: Vec<f64>,
    at: usize,
}

impl Repeats {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], period_s: v[1], given: Vec::new(), at: 0 }
    }
}

impl Hidden for Repeats {
    fn drive(&mut self, seen: &Seen, torque: f64) -> f64 {
        if self.given.is_empty() {
            self.given = vec![0.0; ((self.period_s / seen.step_s).round() as usize).max(1)];
        }
        let acts = torque + self.share * self.given[self.at];
        self.given[self.at] = acts;
        self.at = (self.at + 1) % self.given.len();
        acts
    }
}
