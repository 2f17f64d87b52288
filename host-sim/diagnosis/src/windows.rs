//! The fit in the unit of the position: short simulations from estimated states against the recordings.

use std::ops::Range;

use rayon::prelude::*;

use crate::hypothesis::{Refitted, driven, kept};
use crate::problem::Problem;

/// Root mean square of the windows of each recording, rad (m), at two horizons.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowFit {
    /// One a recording: sum of squares and number of rows, at the short and the long horizon.
    squares: Vec<[(f64, usize); 2]>,
}

/// The horizons of the specification, s: within the shorter a delay shows most, within the longer a force.
pub const HORIZONS_S: [f64; 2] = [0.05, 0.2];
/// No horizon is shorter than this many rows.
const LEAST_ROWS: usize = 8;

impl WindowFit {
    /// Of every recording under a hypothesis.
    pub fn new(problem: &Problem, refitted: &Refitted) -> Option<Self> {
        let physics = refitted.hypothesis.physics(&problem.nominal);
        let path = kept(problem, &physics, &refitted.noise, problem.recordings.len())?;
        let squares = path
            .recordings
            .par_iter()
            .enumerate()
            .map(|(index, kept)| {
                let period_s = problem.recordings[index].period_s();
                HORIZONS_S.map(|horizon_s| {
                    let rows = ((horizon_s / period_s).round() as usize).max(LEAST_ROWS);
                    let windows = kept.prepared.windows(&kept.path, driven(problem, index, &kept.acting), rows);
                    let errors = windows.iter().flat_map(|(_, errors)| errors);
                    errors.fold((0.0, 0), |(sum, rows), error| (sum + error * error, rows + 1))
                })
            })
            .collect();
        Some(Self { squares })
    }

    /// Root mean square over recordings, rad (m); 0 without a window.
    pub fn rms(&self, recordings: Range<usize>, horizon: usize) -> f64 {
        let (sum, rows) = self.squares[recordings]
            .iter()
            .fold((0.0, 0), |(sum, rows), of| (sum + of[horizon].0, rows + of[horizon].1));
        if rows == 0 { 0.0 } else { (sum / rows as f64).sqrt() }
    }

    /// Largest relative fall of the root mean square against another fit, over both horizons, on the recordings that judge.
    pub fn gain_over(&self, other: &Self, problem: &Problem) -> f64 {
        let judged = problem.judged();
        let fall = |horizon: usize| {
            let (before, after) = (other.rms(judged.clone(), horizon), self.rms(judged.clone(), horizon));
            if before > 0.0 { 1.0 - after / before } else { 0.0 }
        };
        fall(0).max(fall(1))
    }
}
