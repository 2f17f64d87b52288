//! The refit: from the values of the search to the optimum in the time domain, with what judges it.

use nalgebra::{DMatrix, DVector};

use super::descent::{descend, sums};
use super::point::{Gauge, Point, Slopes};
use super::track::Tracks;
use super::whiten::{Noise, Sample, likely};
use crate::Error;
use crate::read::Recording;
use crate::screen::{Active, Problem, places, solve_near};

/// Rounds of fit and noise: the noise is what the fit leaves.
const ROUNDS: usize = 2;
/// Windows in motion from one end to the other that make a noise.
const ENOUGH: usize = 10;

/// A hypothesis at its optimum in the time domain. Squares are of residuals of unit variance; windows far beyond the noise
/// count by the root of theirs.
#[derive(Debug, Clone)]
pub struct TimeFit {
    /// Effects with the values found.
    pub active: Vec<Active>,
    /// Sum of squares.
    pub sse: f64,
    /// The same at the values that the refit began with, at their best start states.
    pub start_sse: f64,
    /// Sum of squares in each block of the problem.
    pub blocks: Vec<f64>,
    /// The same as a fit without the block predicts it.
    pub heldout: Vec<f64>,
    /// Rows less start states: what noise alone would leave.
    pub freedom: f64,
    /// Share of the windows whose noise is more than the model's.
    pub far: f64,
    /// Of each block: derivatives by derivatives, start states eliminated.
    pub(crate) normals: Vec<DMatrix<f64>>,
    /// Of each block: derivatives by residual.
    pub(crate) scores: Vec<DVector<f64>>,
}

impl TimeFit {
    /// Refits the values of `start` to the recordings that the problem was built from. `resolution` is the smallest step of
    /// the position, rad (m). Never ends above the values it starts with.
    ///
    /// # Errors
    /// Values that the plant refuses.
    pub fn new(problem: &Problem, recordings: &[Recording], start: &[Active], resolution: f64) -> Result<Self, Error> {
        Self::fit(problem, recordings, start, resolution)
            .map_err(|error| Error::Usage(format!("the improved machine cannot be simulated: {error}")))
    }

    fn fit(
        problem: &Problem,
        recordings: &[Recording],
        start: &[Active],
        resolution: f64,
    ) -> Result<Self, plant::Error> {
        let mut gauge = Gauge { problem, tracks: Tracks::new(problem, recordings) };
        let count = places(start).len();
        let mut point = gauge.settled(gauge.first(start)?, 3)?;
        for _ in 0..ROUNDS {
            for _ in 0..2 {
                let noise = noises(&gauge, &point, resolution);
                gauge.tracks.weigh(&noise);
                point = gauge.weighed(point);
            }
            point = descend(&gauge, point, count)?;
        }
        let first = gauge.settled(gauge.first(start)?, 6)?;
        let start_sse = first.loss();
        if start_sse < point.loss() {
            // Under the last weights the start may be better; then it is where the descent begins.
            point = descend(&gauge, first, count)?;
        }
        let slopes = gauge.slopes(&point, true)?;
        Ok(Self::of(&gauge, point, &slopes, start_sse, count))
    }

    fn of(gauge: &Gauge<'_>, point: Point, slopes: &[Slopes], start_sse: f64, count: usize) -> Self {
        let spans = &gauge.tracks.spans;
        let (normal, gradient) = sums(slopes, count);
        let total = gauge.problem.blocks;
        let mut blocks = vec![0.0; total];
        let mut scores = vec![DVector::zeros(count); total];
        let mut normals = vec![DMatrix::zeros(count, count); total];
        for ((span, shot), slopes) in spans.iter().zip(&point.shots).zip(slopes) {
            blocks[span.block] += shot.loss;
            scores[span.block] += &slopes.gradient;
            normals[span.block] += &slopes.normal;
        }
        let predicted = |block: usize| {
            let mut step = solve_near(&(&normal - &normals[block]), &normal, &(&gradient - &scores[block]));
            for (value, place) in step.iter_mut().zip(places(&point.active)) {
                let now = point.active[place.effect].values[place.value];
                // An event informs its own block only; nothing can predict it from the others.
                let event = point.active[place.effect].effect.id == "disturbance_pulse";
                *value = if event { 0.0 } else { (now + *value).clamp(place.low, place.high) - now };
            }
            (blocks[block] + 2.0 * scores[block].dot(&step) + step.dot(&(&normals[block] * &step))).max(0.0)
        };
        Self {
            sse: point.loss(),
            start_sse,
            heldout: (0..total).map(predicted).collect(),
            blocks,
            freedom: spans.iter().map(|span| span.freedom()).sum(),
            far: point.shots.iter().filter(|shot| shot.weight < 1.0).count() as f64 / spans.len().max(1) as f64,
            active: point.active,
            normals,
            scores,
        }
    }
}

/// The noise of each recording that a point leaves; windows in motion tell it best.
fn noises(gauge: &Gauge<'_>, point: &Point, resolution: f64) -> Vec<Noise> {
    let least = (resolution * resolution / 12.0).max(1e-30);
    (0..gauge.tracks.tracks.len())
        .map(|track| {
            let of = |moving: bool| -> Vec<Sample<'_>> {
                let pairs = gauge.tracks.spans.iter().zip(&point.shots);
                pairs
                    .filter(|(span, _)| span.track == track && (!moving || span.moves))
                    .map(|(span, shot)| Sample {
                        t_s: &gauge.tracks.tracks[track].t_s[span.start..span.end],
                        residual: &shot.residual,
                        weight: shot.weight,
                    })
                    .collect()
            };
            let moving = of(true);
            likely(&if moving.len() < ENOUGH { of(false) } else { moving }, least)
        })
        .collect()
}
