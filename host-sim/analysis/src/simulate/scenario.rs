//! Which reference the axis follows, and what pushes it.

use std::path::Path;

use er_servo::Counts;
use er_servo::experiment::{Experiment, ExperimentError, Sequence};

use super::Disturbance;
use recording::Error;

/// Longest reference from a file, s; that of the experiments.
const LONGEST_S: f64 = 3600.0;

/// A reference, one position a tick.
#[derive(Debug, Clone, PartialEq)]
pub enum Reference {
    /// A built-in experiment of the firmware, to the bit.
    Experiment(Experiment),
    /// Positions read from a file, each held until the next.
    Samples {
        /// s, strictly rising; the first counts as 0.
        t_s: Vec<f64>,
        /// rad.
        reference_rad: Vec<f64>,
    },
}

/// A reference and the pushes that go with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// What the axis follows.
    pub reference: Reference,
    /// What pushes it.
    pub disturbances: Vec<Disturbance>,
}

impl Reference {
    /// Reads a reference from a CSV file with the columns `t_s` and `reference_rad`; other columns are ignored.
    ///
    /// # Errors
    /// A missing column, a cell that is no finite number, time that does not rise, no rows; with file and line.
    pub fn read(file: &Path) -> Result<Self, Error> {
        let bytes =
            std::fs::read(file).map_err(|error| Error::input(file, None, "", format!("cannot open: {error}")))?;
        Self::from_csv_bytes(file, &bytes)
    }

    /// Reads a reference from the bytes of a CSV file; `file` names it in messages.
    ///
    /// # Errors
    /// As [`Reference::read`].
    pub fn from_csv_bytes(file: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let at = |line, key: &str, message: String| Error::input(file, line, key, message);
        let mut reader = csv::Reader::from_reader(bytes);
        let header = reader.headers().map_err(|error| at(Some(1), "", error.to_string()))?.clone();
        let column = |name: &str| {
            let found = header.iter().position(|cell| cell.trim() == name);
            found.ok_or_else(|| at(Some(1), name, "required column missing".to_owned()))
        };
        let (time, position) = (column("t_s")?, column("reference_rad")?);
        let (mut t_s, mut reference_rad): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for record in reader.records() {
            let record =
                record.map_err(|error| at(error.position().map(csv::Position::line), "", error.to_string()))?;
            let line = record.position().map(csv::Position::line);
            let number = |column: usize, key: &str| {
                let cell = record.get(column).unwrap_or("");
                let number = cell.trim().parse::<f64>().ok().filter(|number| number.is_finite());
                number.ok_or_else(|| at(line, key, format!("{cell:?} is not allowed, a finite number is")))
            };
            let now_s = number(time, "t_s")?;
            if t_s.last().is_some_and(|last| *last >= now_s) {
                return Err(at(line, "t_s", format!("{now_s} does not rise")));
            }
            t_s.push(now_s);
            reference_rad.push(number(position, "reference_rad")?);
        }
        if t_s.is_empty() {
            return Err(at(None, "", "no rows; a reference has at least one".to_owned()));
        }
        Ok(Self::Samples { t_s, reference_rad })
    }
}

/// Reference positions, one a tick, until the scenario ends.
#[derive(Debug, Clone)]
pub enum Positions<'a> {
    /// Of an experiment.
    Experiment(Sequence),
    /// Of a file.
    Samples {
        /// Times, s.
        t_s: &'a [f64],
        /// Positions, rad.
        reference_rad: &'a [f64],
        /// Control period, s.
        period_s: f64,
        /// Next tick.
        tick: u32,
        /// Sample that holds now.
        at: usize,
    },
}

impl Reference {
    /// One position for each control period, s.
    ///
    /// # Errors
    /// A value the experiment cannot take, or samples that last longer than an experiment may.
    pub fn positions(&self, period_s: f64) -> Result<Positions<'_>, Error> {
        match self {
            Self::Experiment(experiment) => {
                let sequence = experiment.start(period_s as f32);
                sequence
                    .map(Positions::Experiment)
                    .map_err(|error| Error::Usage(format!("experiment: {}", in_degrees(&error))))
            }
            Self::Samples { t_s, reference_rad } => {
                let length_s = t_s.last().unwrap_or(&0.0) - t_s.first().unwrap_or(&0.0);
                if length_s > LONGEST_S {
                    return Err(Error::Usage(format!("reference: {length_s} s are not allowed, {LONGEST_S} are")));
                }
                Ok(Positions::Samples { t_s, reference_rad, period_s, tick: 0, at: 0 })
            }
        }
    }
}

impl Iterator for Positions<'_> {
    type Item = Counts;

    fn next(&mut self) -> Option<Counts> {
        match self {
            Self::Experiment(sequence) => sequence.next(),
            Self::Samples { t_s, reference_rad, period_s, tick, at } => {
                let first = *t_s.first()?;
                // A tick that falls on a sample to within a millionth of a period takes that sample.
                let now_s = first + (f64::from(*tick) + 1e-6) * *period_s;
                while t_s.get(*at + 1).is_some_and(|next| *next <= now_s) {
                    *at += 1;
                }
                let last_s = *t_s.last()?;
                if now_s > last_s + *period_s {
                    return None;
                }
                *tick += 1;
                reference_rad.get(*at).map(|position| Counts::from_rad(*position))
            }
        }
    }
}

/// What is wrong with an experiment, with angles in the degrees that people give them in.
pub fn in_degrees(error: &ExperimentError) -> String {
    let Some(name) = error.name.strip_suffix("_rad") else { return error.to_string() };
    let degrees = |rad: f32| (100.0 * f64::from(rad).to_degrees()).round() / 100.0;
    let (value, min, max) = (degrees(error.value), degrees(error.min), degrees(error.max));
    format!("{name}_deg: {value} is not allowed, {min} to {max} is")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use er_servo::experiment::Shape;

    fn positions(csv: &str, period_s: f64) -> Vec<i32> {
        let reference = Reference::from_csv_bytes(Path::new("r.csv"), csv.as_bytes()).unwrap();
        reference.positions(period_s).unwrap().map(|counts| counts.0).collect()
    }

    #[test]
    fn each_sample_holds_until_the_next_and_the_last_for_a_period() {
        let one = Counts::from_rad(1.0).0;
        let held = positions("t_s,reference_rad\n0,0\n0.002,1\n0.003,-1\n", 0.0005);
        assert_eq!(held, [0, 0, 0, 0, one, one, -one]);
        // A sample between two ticks acts at the later one; the first counts as 0.
        assert_eq!(positions("t_s,reference_rad\n5.0,0\n5.0012,1\n", 0.0005), [0, 0, 0, one]);
        assert_eq!(positions("reference_rad,note,t_s\n1,a,0\n", 0.0005), [one]);
    }

    #[test]
    fn times_that_ticks_only_reach_by_rounding_are_reached() {
        let csv: String = (0..2000).map(|k| format!("{},{}\n", f64::from(k) * 5e-4, f64::from(k) * 1e-3)).collect();
        let held = positions(&format!("t_s,reference_rad\n{csv}"), 0.0005);
        let expected: Vec<i32> = (0..2000).map(|k| Counts::from_rad(f64::from(k) * 1e-3).0).collect();
        assert_eq!(held[..2000], expected);
    }

    #[test]
    fn bad_references_name_line_and_column() {
        for (csv, message) in [
            ("", "r.csv:1: t_s: required column missing"),
            ("t_s\n0\n", "r.csv:1: reference_rad: required column missing"),
            ("t_s,reference_rad\n", "r.csv: no rows; a reference has at least one"),
            ("t_s,reference_rad\n0,0\n1,x\n", "r.csv:3: reference_rad: \"x\" is not allowed, a finite number is"),
            ("t_s,reference_rad\n0,0\nNaN,1\n", "r.csv:3: t_s: \"NaN\" is not allowed, a finite number is"),
            ("t_s,reference_rad\n0,0\n0,1\n", "r.csv:3: t_s: 0 does not rise"),
        ] {
            let error = Reference::from_csv_bytes(Path::new("r.csv"), csv.as_bytes()).unwrap_err();
            assert_eq!((error.to_string().as_str(), error.exit_code()), (message, 2));
        }
        let torn = Reference::from_csv_bytes(Path::new("r.csv"), b"t_s,reference_rad\n0,0\n1\n").unwrap_err();
        assert!(torn.to_string().starts_with("r.csv:3: ") && torn.to_string().lines().count() == 1, "{torn}");
        let long = Reference::Samples { t_s: vec![0.0, 1e12], reference_rad: vec![0.0, 0.0] };
        assert!(long.positions(0.0005).is_err(), "memory would run out");
    }

    #[test]
    fn an_experiment_is_that_of_the_firmware() {
        let experiment = Experiment { shape: Shape::Step { amplitude_rad: 0.1 }, duration_s: 0.01 };
        let counts: Vec<Counts> = Reference::Experiment(experiment).positions(0.0005).unwrap().collect();
        assert_eq!(counts, experiment.start(0.0005).unwrap().collect::<Vec<_>>());
        let wrong = Experiment { duration_s: -1.0, ..experiment };
        assert!(Reference::Experiment(wrong).positions(0.0005).is_err());
    }
}
