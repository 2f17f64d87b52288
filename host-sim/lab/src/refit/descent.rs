//! Joint bounded least squares over the values of the effects and the start states of all windows.
//!
//! Levenberg-Marquardt with the start states eliminated window by window (they meet in no other window), so that a pass
//! costs two simulations of the recordings and one for each value. Stick-slip has kinks that a difference quotient does not
//! see; where no step goes down any more though much is left, a compass search over the values goes on.

use nalgebra::{DMatrix, DVector};

use super::point::{Gauge, Point, Slopes};
use crate::screen::bounded_step;

/// Passes at most,
const PASSES: usize = 20;
/// and of a machine with a memory, whose pass takes a hundred times longer: one that is there is found in as many.
const PASSES_WITH_MEMORY: usize = 10;

/// When a descent is over.
#[derive(Debug, Clone, Copy)]
pub(super) struct Goal {
    /// A pass that lowers the squares by less than this, in units of the variance, is the last.
    gain: f64,
    /// Where the values have no more to gain than that, start states that still creep to their best are left at a gain of
    /// less than this share of the squares.
    creeping: f64,
}

/// The optimum: nothing more moves a value by more than a tenth of its deviation.
pub(super) const SETTLED: Goal = Goal { gain: 0.01, creeping: 1e-4 };
/// For a first fit, whose weights are not those of the last.
pub(super) const NEAR: Goal = Goal { gain: 1.0, creeping: 1e-3 };
/// Passes in a row after which it is over where the values have no more to gain than that, whatever start states do, or where
/// it creeps and gains not half of what the slopes promise: kinks rule.
const IN_VAIN: usize = 3;
/// Losses beyond this many times the freedom are worth a compass search,
const MUCH: f64 = 1.3;
/// so many times: what is left after that is missing from the model.
const COMPASSES: usize = 2;
/// Steps of the compass search over the deviation of a value, largest first.
const COMPASS: [f64; 5] = [3.0, 1.0, 0.3, 0.1, 0.03];
/// Parts in a row that find nothing are the last.
const IDLE: usize = 2;

/// Sums over the windows: values by values, and values by residual.
pub(super) fn sums(slopes: &[Slopes], count: usize) -> (DMatrix<f64>, DVector<f64>) {
    let start = (DMatrix::zeros(count, count), DVector::zeros(count));
    slopes.iter().fold(start, |(normal, gradient), slopes| (normal + &slopes.normal, gradient + &slopes.gradient))
}

/// Descends from a point to a goal; never ends above it.
pub(super) fn descend(gauge: &Gauge<'_>, start: Point, count: usize, goal: Goal) -> Result<Point, plant::Error> {
    let mut point = gauge.settled(start, 3)?;
    let mut damping = 1e-6;
    let mut compasses = COMPASSES;
    let mut in_vain = 0;
    let memory = gauge.problem.machine(&point.active).remembers();
    let passes = if memory { PASSES_WITH_MEMORY } else { PASSES };
    for _ in 0..passes {
        if gauge.problem.budget.check() {
            break;
        }
        let before = point.loss();
        let slopes = gauge.slopes(&point, true)?;
        let (normal, gradient) = sums(&slopes, count);
        let newton = bounded_step(&point.active, &normal, &gradient, 0.0);
        let promised = -(2.0 * &gradient + &normal * &newton).dot(&newton);
        let mut lower = None;
        while lower.is_none() && damping < 1e4 {
            let step = bounded_step(&point.active, &normal, &gradient, damping);
            // A step that the plant refuses is one that went too far.
            lower = gauge.after(&point, &slopes, &step).ok().filter(|tried| tried.loss() < before);
            damping *= if lower.is_some() { 0.1 } else { 30.0 };
        }
        damping = damping.clamp(1e-9, 1.0);
        point = lower.unwrap_or(point);
        let gain = before - point.loss();
        let creeping = gain < goal.creeping * before;
        let done = promised < goal.gain;
        in_vain = if done || creeping && gain < 0.5 * promised { in_vain + 1 } else { 0 };
        if gain < goal.gain || creeping && done || in_vain == IN_VAIN {
            if point.loss() < MUCH * gauge.tracks.freedom() || compasses == 0 {
                break;
            }
            compasses -= 1;
            in_vain = 0;
            point = compass(gauge, point, &normal)?;
            if before - point.loss() < goal.gain {
                break;
            }
        }
    }
    Ok(point)
}

/// Tries each value that the windows tell up and down by parts of its deviation, until neither of two parts in a row lowers
/// anything; never ends above its start.
fn compass(gauge: &Gauge<'_>, mut point: Point, normal: &DMatrix<f64>) -> Result<Point, plant::Error> {
    let count = normal.nrows();
    let follow = |point: &Point| -> Result<Vec<Slopes>, plant::Error> {
        Ok(gauge.slopes(point, false)?.into_iter().map(|slopes| slopes.without_values(count)).collect())
    };
    let mut slopes = follow(&point)?;
    let mut idle = 0;
    for part in COMPASS {
        let before = point.loss();
        for index in (0..count).filter(|&index| normal[(index, index)] > 0.0) {
            if gauge.problem.budget.check() {
                return Ok(point);
            }
            for sign in [1.0, -1.0] {
                let mut step = DVector::zeros(count);
                step[index] = sign * part / normal[(index, index)].sqrt();
                let Ok(tried) = gauge.after(&point, &slopes, &step) else { continue };
                let tried = gauge.settled(tried, 2)?;
                if tried.loss() < point.loss() {
                    point = tried;
                    slopes = follow(&point)?;
                    break;
                }
            }
        }
        idle = if before - point.loss() < SETTLED.gain { idle + 1 } else { 0 };
        if idle == IDLE {
            break;
        }
    }
    Ok(point)
}
