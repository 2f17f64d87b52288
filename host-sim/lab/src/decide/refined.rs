//! Values and intervals of the answer: those of the time domain where it holds, of the weak form elsewhere.

use super::intervals::{Block, Covariance};
use crate::read::Recording;
use crate::refit::{Probe, TimeFit};
use crate::screen::{Active, Fit, Problem};

/// Share of windows far beyond the noise with which the time domain is no better witness than the weak form.
const FAR: f64 = 0.3;

/// A push is moved so often at most.
const MOVES: usize = 3;

/// The effects of the answer with the values that are reported.
#[derive(Debug, Clone)]
pub struct Refined {
    /// Effects and values.
    pub active: Vec<Active>,
    /// Of the free values.
    pub covariance: Covariance,
    /// The fit in the time domain, where it is the one that is reported.
    pub time: Option<TimeFit>,
    /// Values of one effect that are as likely as the best, where they were felt out: its index, and the ends of each.
    pub spans: Option<(usize, Vec<(f64, f64)>)>,
}

impl Refined {
    /// Refits what a search found. `inflation` is how many neighbouring equations of the weak form count as one,
    /// `resolution` the smallest step of the position, rad (m).
    pub fn new(
        problem: &Problem,
        recordings: &[Recording],
        fit: &Fit,
        inflation: f64,
        resolution: f64,
        warnings: &mut Vec<String>,
    ) -> Self {
        let weak = || Self {
            active: fit.active.clone(),
            covariance: Covariance::new(problem, fit, inflation),
            time: None,
            spans: None,
        };
        if fit.active.is_empty() || problem.budget.check() {
            return weak();
        }
        let simulated = TimeFit::new(problem, recordings, &fit.active, resolution);
        match simulated.map(|time| elsewhere(problem, recordings, time)) {
            Ok(time) if time.far <= FAR && time.sse <= time.start_sse && informed(&time, fit, problem) => {
                Self { active: time.active.clone(), covariance: covariance(&time), time: Some(time), spans: None }
            }
            Ok(time) if time.far <= FAR => weak(),
            Ok(time) => {
                warnings.push(format!(
                    "values and intervals are those of the weak form: simulated, {:.0} % of the windows are far from the \
                     recording even with the best values",
                    100.0 * time.far
                ));
                weak()
            }
            Err(error) => {
                warnings.push(format!("values and intervals are those of the weak form: {error}"));
                weak()
            }
        }
    }
}

/// The fit from where each of its pushes leaves less, as long as that helps.
fn elsewhere(problem: &Problem, recordings: &[Recording], time: TimeFit) -> TimeFit {
    let mut best = time;
    for index in 0..best.active.len() {
        for _ in 0..MOVES {
            if problem.budget.check() {
                return best;
            }
            let around = Probe::around(problem, recordings, &best, index);
            let Some(moved) = around.and_then(|probe| probe.elsewhere(&best.active, index)) else { break };
            match best.rival(problem, recordings, &moved) {
                Ok(fit) if fit.sse < best.sse => best = fit,
                _ => break,
            }
        }
    }
    best
}

/// Whether the simulated windows tell every value: a friction that would drive is clipped by the plant, and its slope is
/// then told by nothing.
fn informed(time: &TimeFit, fit: &Fit, problem: &Problem) -> bool {
    let mut column = 0;
    fit.active.iter().all(|entry| {
        // A push may begin or end while the rotor holds; its interval says so.
        let event = entry.effect.is_event();
        (0..entry.values.len()).filter(|&value| entry.effect.parameter(value).free).all(|value| {
            let known = time.normals.iter().any(|normal| normal[(column, column)] > 0.0);
            column += 1;
            event || known || entry.effect.recording_of(value).is_some_and(|recording| recording >= problem.fitted)
        })
    })
}

/// Of a fit in the time domain, whose white residuals share no noise.
fn covariance(time: &TimeFit) -> Covariance {
    let pairs = time.normals.iter().zip(&time.scores);
    let blocks: Vec<Block> =
        pairs.map(|(normal, score)| Block { normal: normal.clone(), score: score.clone() }).collect();
    let count = time.scores.first().map_or(0, |score| score.len());
    Covariance::of_blocks(&blocks, count, time.sse / (time.freedom - count as f64).max(1.0))
}
