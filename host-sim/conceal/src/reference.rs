//! What the axis follows: families drawn from a seed.

use er_servo::Counts;
use er_servo::experiment::{Experiment, Shape};
use rand::Rng;
use rand::rngs::StdRng;

use crate::Error;

/// A kind of reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// A new level after each dwell.
    Steps,
    /// Eight tones.
    Multisine,
    /// One sine from slow to fast.
    Chirp,
    /// To and fro at constant speed.
    Ramp,
    /// At rest; pushes come from the machine.
    Rest,
    /// One slow sine: excites little.
    SlowSine,
}

impl Family {
    /// A shape of this family with drawn size and speed.
    pub fn draw(self, random: &mut StdRng) -> Shape {
        let scale: f32 = random.random_range(0.8..1.2);
        match self {
            Self::Steps => Shape::Steps { amplitude_rad: 0.7 * scale, dwell_s: 0.45 * scale, seed: random.random() },
            Self::Multisine => Shape::Multisine { amplitude_rad: 0.5 * scale, low_hz: 0.2, high_hz: 3.0, tones: 8 },
            Self::Chirp => Shape::Chirp { amplitude_rad: 0.25 * scale, from_hz: 0.1, to_hz: 4.0 },
            Self::Ramp => Shape::Ramp { speed_rad_s: 0.6 * scale, travel_rad: 0.5 },
            Self::Rest => Shape::Step { amplitude_rad: 0.0 },
            Self::SlowSine => Shape::Chirp { amplitude_rad: 0.3 * scale, from_hz: 0.2, to_hz: 0.2 },
        }
    }
}

/// The reference, one position a control period, s.
///
/// # Errors
/// A shape the sequencer refuses.
pub fn positions(shape: Shape, duration_s: f32, period_s: f32) -> Result<Vec<Counts>, Error> {
    let sequence = Experiment { shape, duration_s }.start(period_s).map_err(Error::Reference)?;
    Ok(sequence.collect())
}
