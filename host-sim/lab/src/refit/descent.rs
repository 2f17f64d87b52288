//! Joint bounded least squares over the values of the effects and the start states of all windows.
//!
//! Levenberg-Marquardt with the start states eliminated window by window (they meet in no other window), so that a pass
//! costs two simulations of the recordings and one for each value. Stick-slip has kinks that a difference quotient does not
//! see; where no step goes down any more though much is left, a compass search over the values goes on.

use nalgebra::{DMatrix, DVector};

use super::point::{Gauge, Point, Slopes};
use crate::screen::bounded_step;

/// Passes at most.
const PASSES: usize = 20;
/// A pass that lowers the squares by less than this, in units of the variance, is the last: it moves no value by more than
/// a tenth of its deviation.
const SETTLED: f64 = 0.01;
/// Where the values have no more to gain than that, start states that still creep to their best are left at a gain of less
/// than this share of the squares.
const CREEPING: f64 = 1e-4;
/// Losses beyond this many times the freedom are worth a compass search,
const MUCH: f64 = 1.3;
/// so many times: what is left after that is missing from the model.
const COMPASSES: usize = 2;
/// Steps of the compass search over the deviation of a value, largest first.
const COMPASS: [f64; 5] = [3.0, 1.0, 0.3, 0.1, 0.03];

/// Sums over the windows: values by values, and values by residual.
pub(super) fn sums(slopes: &[Slopes], count: usize) -> (DMatrix<f64>, DVector<f64>) {
    let start = (DMatrix::zeros(count, count), DVector::zeros(count));
    slopes.iter().fold(start, |(normal, gradient), slopes| (normal + &slopes.normal, gradient + &slopes.gradient))
}

/// Descends from a point; never ends above it.
pub(super) fn descend(gauge: &Gauge<'_>, start: Point, count: usize) -> Result<Point, plant::Error> {
    let mut point = gauge.settled(start, 3)?;
    let mut damping = 1e-6;
    let mut compasses = COMPASSES;
    for _ in 0..PASSES {
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
        if gain < SETTLED || promised < SETTLED && gain < CREEPING * before {
            let freedom: f64 = gauge.tracks.spans.iter().map(|span| span.freedom()).sum();
            if point.loss() < MUCH * freedom || compasses == 0 {
                break;
            }
            compasses -= 1;
            point = compass(gauge, point, &normal)?;
            if before - point.loss() < SETTLED {
                break;
            }
        }
    }
    Ok(point)
}

/// Tries each value up and down by parts of its deviation; never ends above its start.
fn compass(gauge: &Gauge<'_>, mut point: Point, normal: &DMatrix<f64>) -> Result<Point, plant::Error> {
    for part in COMPASS {
        for index in 0..normal.nrows() {
            for sign in [1.0, -1.0] {
                let mut step = DVector::zeros(normal.nrows());
                step[index] = sign * part / normal[(index, index)].max(1e-300).sqrt();
                let slopes = gauge.slopes(&point, false)?;
                let follow: Vec<Slopes> = slopes.into_iter().map(|slopes| slopes.without_values(step.len())).collect();
                let Ok(tried) = gauge.after(&point, &follow, &step) else { continue };
                let tried = gauge.settled(tried, 2)?;
                if tried.loss() < point.loss() {
                    point = tried;
                    break;
                }
            }
        }
    }
    Ok(point)
}
