//! Which reference the axis follows, and what pushes it.

use std::path::Path;

use er_servo::Counts;
use er_servo::experiment::{Experiment, Sequence};

use super::Disturbance;
use crate::Error;

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
        let at = |line, key: &str, message: String| Error::input(file, line, key, message);
        let mut reader = csv::Reader::from_path(file).map_err(|error| at(None, "", error.to_string()))?;
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
    /// A value the experiment cannot take.
    pub fn positions(&self, period_s: f64) -> Result<Positions<'_>, Error> {
        match self {
            Self::Experiment(experiment) => {
                let sequence = experiment.start(period_s as f32);
                sequence.map(Positions::Experiment).map_err(|error| Error::Usage(format!("experiment: {error}")))
            }
            Self::Samples { t_s, reference_rad } => {
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
