//! Values by the slopes of the likelihood itself, where the linearised pass leads no further.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::refit::{FIRST_DAMPING, Refitted, SETTLED, at, moved_by, ranges};
use crate::effects::Range;
use crate::problem::Problem;

/// Steps by differences of the likelihood at most, and halvings of one that leads too far.
const STEPS_BY_DIFFERENCES: usize = 3;
const HALVED: usize = 3;

/// Goes on where the linearised pass leads no further, by the slopes of the likelihood itself: how a value changes what the belief knows, as
/// friction makes it where a rotor nearly sticks, is in those alone. An offset had been left at three quarters of its size.
pub(super) fn by_differences(problem: &Problem, mut best: Refitted, information: Option<&DMatrix<f64>>) -> Refitted {
    let Some(information) = information else { return best };
    for _ in 0..STEPS_BY_DIFFERENCES {
        if problem.is_spent() {
            break;
        }
        let gradient = slopes(problem, &best, information);
        let tried = moved_by(problem, &best.hypothesis, information, &gradient, FIRST_DAMPING);
        let Some((whole, _)) = tried.filter(|(_, promised)| *promised >= SETTLED) else { break };
        let before = best.log_likelihood;
        for halvings in 0..HALVED as i32 {
            let step = f64::exp2(f64::from(-halvings));
            let found = at(problem, best.hypothesis.towards(&whole, step), best.noise.clone());
            if let Some(found) = found.filter(|found| found.log_likelihood > before) {
                best = found;
                break;
            }
        }
        if best.log_likelihood - before < SETTLED {
            break;
        }
    }
    best
}

/// Slopes of the log-likelihood over the free values; 0 where none can be had or a value moves nothing.
fn slopes(problem: &Problem, best: &Refitted, information: &DMatrix<f64>) -> DVector<f64> {
    let places: Vec<_> = best.hypothesis.free().into_iter().zip(ranges(problem, &best.hypothesis)).collect();
    let curvatures: Vec<f64> = information.diagonal().iter().copied().collect();
    let slopes = places.into_par_iter().zip(curvatures);
    DVector::from_vec(slopes.map(|(of, curvature)| slope(problem, best, of, curvature).unwrap_or(0.0)).collect())
}

/// Slope over half a standard deviation of a value, less what its curvature makes of that.
fn slope(problem: &Problem, best: &Refitted, (place, range): ((usize, usize), Range), curvature: f64) -> Option<f64> {
    let value = best.hypothesis.entries[place.0].values[place.1];
    let step = range.allowed(value, 0.5 / curvature.sqrt());
    if !step.is_finite() || value + step < range.low {
        return None;
    }
    let moved = at(problem, best.hypothesis.moved(place, step), best.noise.clone())?;
    let rise = moved.log_likelihood - best.log_likelihood;
    let slope = (rise + 0.5 * curvature * step * step) / step;
    (rise != 0.0 && slope.is_finite()).then_some(slope)
}
