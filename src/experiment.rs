//! Built-in experiments: references that excite the machine, the same to the bit in the firmware and on a host.
//!
//! All of them are offsets from where the axis stood at the start, in counts, begin at 0 and last `duration_s`.

use crate::maths;
use crate::units::{Counts, RAD_PER_COUNT};

/// Most tones of a [`Shape::Multisine`].
pub const MAX_TONES: u8 = 16;

/// What the reference does.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Shape {
    /// One step at once.
    Step {
        /// Height, rad.
        amplitude_rad: f32,
    },
    /// A new level, drawn evenly within the amplitude, after each dwell.
    Steps {
        /// Largest level either way, rad.
        amplitude_rad: f32,
        /// Time at each level, s.
        dwell_s: f32,
        /// Of the draw; the same seed gives the same levels.
        seed: u32,
    },
    /// Equal tones spaced evenly over a band, with Schroeder phases (low crest factor).
    Multisine {
        /// Bound of the sum either way before it is shifted to begin at 0, rad; after it, at most twice this.
        amplitude_rad: f32,
        /// Lowest tone, Hz.
        low_hz: f32,
        /// Highest tone, Hz.
        high_hz: f32,
        /// Number of tones, 1 to [`MAX_TONES`].
        tones: u8,
    },
    /// One sine whose frequency runs evenly from one end to the other over the duration.
    Chirp {
        /// Amplitude, rad.
        amplitude_rad: f32,
        /// Frequency at the start, Hz.
        from_hz: f32,
        /// Frequency at the end, Hz.
        to_hz: f32,
    },
    /// To and fro at constant speed.
    Ramp {
        /// Speed, rad/s.
        speed_rad_s: f32,
        /// Turning point, rad.
        travel_rad: f32,
    },
}

/// A shape and how long it lasts.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Experiment {
    /// What the reference does.
    pub shape: Shape,
    /// For how long, s.
    pub duration_s: f32,
}

/// A value an experiment cannot take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExperimentError {
    /// Which.
    pub name: &'static str,
    /// What was asked for.
    pub value: f32,
    /// Smallest value allowed.
    pub min: f32,
    /// Largest value allowed.
    pub max: f32,
}

impl core::fmt::Display for ExperimentError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}: {} is not allowed, {} to {} is", self.name, self.value, self.min, self.max)
    }
}

impl core::error::Error for ExperimentError {}

fn within(name: &'static str, value: f32, min: f32, max: f32) -> Result<f32, ExperimentError> {
    if value >= min && value <= max { Ok(value) } else { Err(ExperimentError { name, value, min, max }) }
}

fn amplitude_counts(amplitude_rad: f32) -> Result<f32, ExperimentError> {
    Ok(within("amplitude_rad", amplitude_rad, -6.3, 6.3)? / RAD_PER_COUNT)
}

fn frequency_hz(name: &'static str, hz: f32) -> Result<f32, ExperimentError> {
    within(name, hz, 0.0, 100.0)
}

impl Experiment {
    /// Checks the values and prepares the sequence for a control period, s.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn start(&self, period_s: f32) -> Result<Sequence, ExperimentError> {
        let period_s = within("period_s", period_s, 1e-4, 1e-1)?;
        let duration_s = within("duration_s", self.duration_s, period_s, 3600.0)?;
        let ticks = (duration_s / period_s + 0.5) as u32;
        let turn_per_hz = period_s * 4_294_967_296.0;
        let run = match self.shape {
            Shape::Step { amplitude_rad } => Run::Step { counts: amplitude_counts(amplitude_rad)? },
            Shape::Steps { amplitude_rad, dwell_s, seed } => Run::Steps {
                counts: amplitude_counts(amplitude_rad)?,
                dwell_ticks: (within("dwell_s", dwell_s, period_s, 3600.0)? / period_s + 0.5) as u32,
                // A xorshift generator must not start at 0.
                random: seed ^ 0x9e37_79b9 | 1,
                level: 0.0,
            },
            Shape::Multisine { amplitude_rad, low_hz, high_hz, tones } => {
                within("tones", f32::from(tones), 1.0, f32::from(MAX_TONES))?;
                let (low, high) = (frequency_hz("low_hz", low_hz)?, frequency_hz("high_hz", high_hz)?);
                within("high_hz", high, low, 100.0)?;
                let spacing_hz = (high - low) / f32::from(tones - 1).max(1.0);
                multisine(amplitude_counts(amplitude_rad)?, low * turn_per_hz, spacing_hz * turn_per_hz, tones)
            }
            Shape::Chirp { amplitude_rad, from_hz, to_hz } => {
                let (from, to) = (frequency_hz("from_hz", from_hz)?, frequency_hz("to_hz", to_hz)?);
                Run::Chirp {
                    counts: amplitude_counts(amplitude_rad)?,
                    phase: 0,
                    rate: from * turn_per_hz,
                    rate_change: (to - from) * turn_per_hz / ticks as f32,
                }
            }
            Shape::Ramp { speed_rad_s, travel_rad } => Run::Ramp {
                step: within("speed_rad_s", speed_rad_s, 1e-4, 50.0)? * period_s / RAD_PER_COUNT,
                travel: within("travel_rad", travel_rad, 1e-4, 600.0)? / RAD_PER_COUNT,
                at: 0.0,
                back: false,
            },
        };
        Ok(Sequence { run, tick: 0, ticks })
    }
}

fn multisine(counts: f32, first_rate: f32, rate_spacing: f32, tones: u8) -> Run {
    let count = u32::from(tones);
    let (mut rates, mut phases) = ([0; MAX_TONES as usize], [0; MAX_TONES as usize]);
    for (k, (rate, phase)) in (0..count).zip(rates.iter_mut().zip(phases.iter_mut())) {
        *rate = (first_rate + rate_spacing * k as f32) as u32;
        // Schroeder: -pi k (k - 1)/N, that is k (k - 1)/2N of a turn, backwards.
        let half_turns = k * k.saturating_sub(1) % (2 * count);
        *phase = (((u64::from(half_turns) << 32) / u64::from(2 * count)) as u32).wrapping_neg();
    }
    Run::Multisine { counts: counts / f32::from(tones), tones, rates, phases }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Run {
    Step { counts: f32 },
    Steps { counts: f32, dwell_ticks: u32, random: u32, level: f32 },
    Multisine { counts: f32, tones: u8, rates: [u32; MAX_TONES as usize], phases: [u32; MAX_TONES as usize] },
    Chirp { counts: f32, phase: u32, rate: f32, rate_change: f32 },
    Ramp { step: f32, travel: f32, at: f32, back: bool },
}

/// A running experiment: one offset a tick, then the end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sequence {
    run: Run,
    tick: u32,
    ticks: u32,
}

impl Iterator for Sequence {
    type Item = Counts;

    fn next(&mut self) -> Option<Counts> {
        if self.tick >= self.ticks {
            return None;
        }
        let offset = self.run.offset(self.tick);
        self.tick += 1;
        Some(Counts(offset as i32))
    }
}

impl Run {
    fn offset(&mut self, tick: u32) -> f32 {
        match self {
            Self::Step { counts } => *counts,
            Self::Steps { counts, dwell_ticks, random, level } => {
                if tick > 0 && tick.is_multiple_of(*dwell_ticks) {
                    *random ^= *random << 13;
                    *random ^= *random >> 17;
                    *random ^= *random << 5;
                    // The upper 24 bits are exact in single precision.
                    *level = *counts * ((*random >> 8) as f32 / 8_388_608.0 - 1.0);
                }
                *level
            }
            Self::Multisine { counts, tones, rates, phases } => {
                let mut sum = 0.0;
                for (rate, phase) in rates.iter().zip(phases.iter()).take(usize::from(*tones)) {
                    // Each tone less its value at the start, so that the sum begins at 0.
                    sum += maths::sin_phase(phase.wrapping_add(rate.wrapping_mul(tick))) - maths::sin_phase(*phase);
                }
                *counts * sum
            }
            Self::Chirp { counts, phase, rate, rate_change } => {
                let now = *counts * maths::sin_phase(*phase);
                *phase = phase.wrapping_add((*rate + *rate_change * tick as f32) as u32);
                now
            }
            Self::Ramp { step, travel, at, back } => {
                let now = *at;
                let next = if *back { *at - *step } else { *at + *step };
                if next >= *travel || next <= 0.0 {
                    *back = next >= *travel;
                }
                *at = maths::limit(next, 0.0, *travel).0;
                now
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn run(shape: Shape, duration_s: f32) -> Vec<i32> {
        Experiment { shape, duration_s }.start(0.0005).unwrap().map(|counts| counts.0).collect()
    }

    #[test]
    fn each_begins_at_rest_and_lasts_its_time() {
        let shapes = [
            Shape::Steps { amplitude_rad: 0.5, dwell_s: 0.2, seed: 1 },
            Shape::Multisine { amplitude_rad: 0.2, low_hz: 0.5, high_hz: 8.0, tones: 16 },
            Shape::Chirp { amplitude_rad: 0.2, from_hz: 0.1, to_hz: 10.0 },
            Shape::Ramp { speed_rad_s: 1.0, travel_rad: 0.3 },
        ];
        for shape in shapes {
            let counts = run(shape, 3.0);
            assert_eq!((counts.len(), counts[0]), (6000, 0), "{shape:?}");
            assert!(counts.iter().any(|&c| c.abs() > 1000), "{shape:?} moves");
        }
        assert_eq!(run(Shape::Step { amplitude_rad: core::f32::consts::FRAC_PI_6 }, 1.0)[0], 40_960);
    }

    #[test]
    fn the_chirp_is_the_sine_of_the_integral_of_its_frequency() {
        let counts = run(Shape::Chirp { amplitude_rad: 1.0, from_hz: 1.0, to_hz: 5.0 }, 4.0);
        for (k, &c) in counts.iter().enumerate() {
            let t = k as f64 * 0.0005;
            let phase = core::f64::consts::TAU * (t + 0.5 * t * (t - 0.0005));
            assert!((f64::from(c) * f64::from(RAD_PER_COUNT) - phase.sin()).abs() < 2e-3, "tick {k}");
        }
    }

    #[test]
    fn the_ramp_keeps_its_speed_and_its_travel() {
        let counts = run(Shape::Ramp { speed_rad_s: 1.0, travel_rad: 0.3 }, 2.0);
        let top = (0.3 / RAD_PER_COUNT) as i32;
        assert_eq!(counts.iter().max(), Some(&top));
        assert_eq!(counts.iter().min(), Some(&0));
        assert!(counts.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= 40));
    }

    #[test]
    fn values_out_of_range_are_named() {
        let error =
            Experiment { shape: Shape::Chirp { amplitude_rad: 0.1, from_hz: 1.0, to_hz: 400.0 }, duration_s: 1.0 }
                .start(0.0005)
                .unwrap_err();
        assert_eq!((error.name, error.max), ("to_hz", 100.0));
        let nan = Experiment { shape: Shape::Step { amplitude_rad: f32::NAN }, duration_s: 1.0 };
        assert_eq!(nan.start(0.0005).unwrap_err().name, "amplitude_rad");
    }

    proptest! {
        #[test]
        fn any_values_give_a_bounded_sequence_or_an_error(
            a: f32, b: f32, c: f32, tones: u8, seed: u32, duration_s in 0.0..0.2_f32, kind in 0..5,
        ) {
            let shape = match kind {
                0 => Shape::Step { amplitude_rad: a },
                1 => Shape::Steps { amplitude_rad: a, dwell_s: b, seed },
                2 => Shape::Multisine { amplitude_rad: a, low_hz: b, high_hz: c, tones },
                3 => Shape::Chirp { amplitude_rad: a, from_hz: b, to_hz: c },
                _ => Shape::Ramp { speed_rad_s: a, travel_rad: b },
            };
            if let Ok(sequence) = (Experiment { shape, duration_s }).start(0.0005) {
                for counts in sequence {
                    prop_assert!(counts.0.abs() < 47_000_000);
                }
            }
        }
    }
}
