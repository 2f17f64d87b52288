//! What the axis follows: families drawn from a seed, none of them the drive's own sequencer.

use std::f64::consts::{PI, TAU};

use er_servo::Counts;
use rand::Rng;
use rand::rngs::StdRng;

use crate::Error;

/// A kind of reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// A new level after each dwell.
    Steps,
    /// To and fro between two levels: the field rises and falls at regular times.
    Square,
    /// Eight tones.
    Multisine,
    /// One sine from slow to fast.
    Chirp,
    /// To and fro at constant speed.
    Ramp,
    /// Moves at constant speed with rests between.
    Stops,
    /// Triangles that grow: reversals everywhere.
    Reversals,
    /// At rest; what moves the axis comes from outside.
    Rest,
    /// One slow sine: excites little.
    SlowSine,
    /// One step, then rest.
    SingleStep,
}

/// Single steps: those of the paper, 10 to 30 degrees.
const STEPS_RAD: std::ops::Range<f64> = 10.0 / 180.0 * PI..30.0 / 180.0 * PI;
/// Rest before one, s.
const BEFORE_A_STEP_S: f64 = 0.05;

/// Families that excite every effect between them.
pub const RICH: [Family; 7] =
    [Family::Steps, Family::Square, Family::Multisine, Family::Chirp, Family::Ramp, Family::Stops, Family::Reversals];

impl Family {
    /// A reference of this family with drawn size and speed: one position a control period, s.
    pub fn draw(self, duration_s: f64, period_s: f64, random: &mut StdRng) -> Vec<Counts> {
        self.draw_rad(duration_s, period_s, random).into_iter().map(Counts::from_rad).collect()
    }

    /// As [`Self::draw`], rad.
    pub fn draw_rad(self, duration_s: f64, period_s: f64, random: &mut StdRng) -> Vec<f64> {
        let scale: f64 = random.random_range(0.8..1.2);
        let rows = (duration_s / period_s).round() as usize;
        let times = (0..rows).map(|row| row as f64 * period_s);
        match self {
            Self::Steps => {
                let dwell_s = 0.45 * scale;
                let levels: Vec<f64> = levels(0.7 * scale, (duration_s / dwell_s) as usize + 1, random);
                times.map(|t| levels[(t / dwell_s) as usize]).collect()
            }
            Self::Square => {
                let half_s = 0.5 * scale;
                times.map(|t| if (t / half_s) as usize % 2 == 1 { 0.3 * scale } else { 0.0 }).collect()
            }
            Self::Multisine => multisine(0.3 * scale, times, random),
            Self::Chirp => {
                let sweep = 3.9 / duration_s;
                times.map(|t| 0.25 * scale * (TAU * (0.1 + 0.5 * sweep * t) * t).sin()).collect()
            }
            Self::Ramp => times.map(|t| 0.5 * triangle(0.6 * scale * t / 0.5)).collect(),
            Self::Stops => times.map(|t| 0.4 * stops(t / (0.9 * scale))).collect(),
            Self::Reversals => times.map(|t| (0.05 + 0.4 * t / duration_s) * triangle(2.4 * scale * t)).collect(),
            Self::Rest => vec![0.0; rows],
            Self::SlowSine => times.map(|t| 0.3 * scale * (TAU * 0.2 * t).sin()).collect(),
            Self::SingleStep => {
                let step_rad = random.random_range(STEPS_RAD);
                times.map(|t| if t < BEFORE_A_STEP_S { 0.0 } else { step_rad }).collect()
            }
        }
    }
}

/// Levels evenly drawn within an amplitude; the first is where the axis stands.
fn levels(amplitude: f64, number: usize, random: &mut StdRng) -> Vec<f64> {
    let mut levels = vec![0.0];
    levels.extend((0..number).map(|_| random.random_range(-amplitude..amplitude)));
    levels
}

/// Eight tones between 0.2 and 3 Hz with drawn phases, faded in so that it begins at rest.
fn multisine(amplitude: f64, times: impl Iterator<Item = f64>, random: &mut StdRng) -> Vec<f64> {
    let tones: Vec<(f64, f64)> = (0..8).map(|k| (0.2 + 0.4 * f64::from(k), random.random_range(-PI..PI))).collect();
    let at = |t: f64| -> f64 { tones.iter().map(|(hz, phase)| (TAU * hz * t + phase).sin()).sum() };
    times.map(|t| amplitude / 2.0 * at(t) * (t / 0.5).min(1.0)).collect()
}

/// Between -1 and 1 at a slope of one, from 0.
fn triangle(way: f64) -> f64 {
    1.0 - ((way + 3.0).rem_euclid(4.0) - 2.0).abs()
}

/// Up in one unit, rest for half a unit, down, rest.
fn stops(time: f64) -> f64 {
    let within = time.rem_euclid(3.0);
    if within < 1.5 { within.min(1.0) } else { (2.5 - within).max(0.0) }
}

/// A reference from a CSV file with the columns `t_s` and `reference_rad`, held from row to row, as one position a
/// control period, s.
///
/// # Errors
/// Text that is no such table, or longer than a minute.
pub fn from_csv(text: &str, period_s: f64) -> Result<Vec<Counts>, Error> {
    Ok(from_csv_rad(text, period_s)?.into_iter().map(Counts::from_rad).collect())
}

/// As [`from_csv`], in rad, or in m from a column `reference_m`.
///
/// # Errors
/// As [`from_csv`].
pub fn from_csv_rad(text: &str, period_s: f64) -> Result<Vec<f64>, Error> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers()?.clone();
    let column = |name: &str| header.iter().position(|cell| cell.trim() == name);
    let wrong = |message: &str| Error::ReferenceFile(message.to_owned());
    let (Some(time), Some(position)) = (column("t_s"), column("reference_rad").or_else(|| column("reference_m")))
    else {
        return Err(wrong("the columns t_s and reference_rad, or reference_m, are needed"));
    };
    let mut samples: Vec<(f64, f64)> = Vec::new();
    for row in reader.records() {
        let row = row?;
        let number = |at: usize| row.get(at).and_then(|cell| cell.trim().parse().ok()).filter(|v: &f64| v.is_finite());
        samples.push(number(time).zip(number(position)).ok_or_else(|| wrong("a cell is no number"))?);
    }
    let (Some(first), Some(last)) = (samples.first().copied(), samples.last()) else {
        return Err(wrong("no rows"));
    };
    let rows = ((last.0 - first.0) / period_s).round() as usize + 1;
    if last.0 - first.0 > 60.0 {
        return Err(wrong("longer than 60 s"));
    }
    let held = |row: usize| {
        let now = first.0 + (row as f64 + 1e-6) * period_s;
        let after = samples.partition_point(|(t, _)| *t <= now);
        samples[after.max(1) - 1].1
    };
    Ok((0..rows).map(held).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn every_family_begins_where_the_axis_stands_and_repeats_by_seed() {
        for family in RICH.into_iter().chain([Family::Rest, Family::SlowSine, Family::SingleStep]) {
            let draw = |seed| family.draw(2.0, 0.0005, &mut StdRng::seed_from_u64(seed));
            assert_eq!(draw(1).len(), 4000);
            assert_eq!(draw(1)[0], Counts(0), "{family:?}");
            assert_eq!(draw(1), draw(1));
            assert!(family == Family::Rest || draw(1) != draw(2), "{family:?}");
        }
    }

    #[test]
    fn a_reference_from_a_file_is_held() {
        let one = Counts::from_rad(1.0);
        let read = from_csv("t_s,reference_rad\n5.0,0\n5.0012,1\n", 0.0005).unwrap();
        assert_eq!(read, [Counts(0), Counts(0), Counts(0)]);
        assert_eq!(from_csv("t_s,reference_rad\n0,0\n0.001,1\n0.0015,1\n", 0.0005).unwrap()[2..], [one, one]);
        assert!(from_csv("t_s\n0\n", 0.0005).is_err());
    }
}
