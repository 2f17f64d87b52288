//! The position sensor at work.

use rand::Rng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, Normal};

use crate::delay::DeadTime;
use crate::outside::{Hidden, Hiding};
use crate::physics::{Physics, Sensor};

/// A draw from the normal distribution.
pub(crate) fn unit_normal(random: &mut StdRng) -> f64 {
    Normal::new(0.0, 1.0).map_or(0.0, |normal: Normal<f64>| normal.sample(random))
}

/// The sensor with what it remembers.
pub(crate) struct Measured<'a> {
    law: &'a Sensor,
    late: DeadTime,
    last_was_wrong: bool,
    hidden: Option<Box<dyn Hidden>>,
}

impl<'a> Measured<'a> {
    /// Before the first step, s long.
    pub(crate) fn new(physics: &'a Physics, step_s: f64) -> Self {
        Self {
            law: &physics.sensor,
            late: DeadTime::new(physics.sensor.latency_s, step_s, 0.0),
            last_was_wrong: false,
            hidden: physics.hidden.as_ref().and_then(Hiding::begin),
        }
    }

    /// Sees the angle at the start of a step.
    pub(crate) fn watch(&mut self, position_rad: f64) {
        if self.law.latency_s > 0.0 {
            self.late.pass(position_rad);
        }
    }

    /// Feels the torque that the drive had at the last step.
    pub(crate) fn feel(&mut self, drive_nm: f64) {
        if let Some(hidden) = &mut self.hidden {
            hidden.feels(drive_nm);
        }
    }

    /// Reading at the end of a step, rad, not yet in steps of the sensor.
    pub(crate) fn sample(&mut self, position_rad: f64, random: &mut StdRng) -> f64 {
        // The ring last saw the start of the step that ends now: one step late, which a copy makes up for.
        let seen_rad = if self.law.latency_s > 0.0 { self.late.clone().pass(position_rad) } else { position_rad };
        let mut angle = seen_rad + self.law.eccentricity.map_or(0.0, |wave| wave.at(seen_rad));
        if let Some(hidden) = &mut self.hidden {
            angle = hidden.measured(angle);
        }
        if let Some((fraction, size_rad)) = self.law.glitch {
            let wrong = !self.last_was_wrong && random.random_bool(fraction);
            if wrong {
                angle += if random.random_bool(0.5) { size_rad } else { -size_rad };
            }
            self.last_was_wrong = wrong;
        }
        angle + self.law.noise_rad * unit_normal(random)
    }
}
