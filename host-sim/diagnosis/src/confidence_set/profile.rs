//! Where the likelihood itself falls as far as its quadratic says: intervals of values that it tells more of one way than the other, as
//! the speed of a Stribeck friction (Venzon and Moolgavkar 1988, along the line on which the quadratic has its own profile).

use nalgebra::DVector;

use super::Step;
use super::information::Assessed;
use super::intervals::{half_width, slopes};
use crate::hypothesis::{evaluate, ranges, variance_along};
use crate::problem::Problem;

/// By what half the intervals of each entry's reported values are stretched downwards and upwards, and the variances of the numbers that
/// no derivative tells.
#[derive(Debug, Clone, Default)]
pub(super) struct Profile {
    stretches: Vec<Vec<[f64; 2]>>,
    variances: Vec<((usize, usize), f64)>,
}

impl Profile {
    pub(super) fn stretch(&self, entry: usize, value: usize) -> [f64; 2] {
        self.stretches.get(entry).and_then(|of| of.get(value)).copied().unwrap_or([1.0; 2])
    }

    pub(super) fn variance(&self, entry: usize, value: usize) -> Option<f64> {
        self.variances.iter().find(|(place, _)| *place == (entry, value)).map(|(_, variance)| *variance)
    }
}

/// Intervals are not stretched by more: beyond it the line that is followed is no profile any more. Nor are they shrunk, for the line
/// is at best the profile, which falls less.
const MOST_STRETCHED: f64 = 3.0;
/// Passes to each end.
const TRIES: usize = 3;

impl Step {
    /// With what the likelihood says at the ends of the intervals.
    #[must_use]
    pub fn profiled(mut self, problem: &Problem) -> Self {
        let best = &self.assessed;
        let hypothesis = &best.refitted.hypothesis;
        let numbers = hypothesis.searched().into_iter();
        let variances = numbers.map(|place| (place, variance_along(problem, &best.refitted, place))).collect();
        let of_entry = |at: usize| {
            let slopes = slopes(best, at);
            slopes.iter().map(|slopes| [-1.0, 1.0].map(|sign| stretch(problem, best, slopes, sign))).collect()
        };
        let stretches = (0..hypothesis.entries.len()).map(of_entry).collect();
        self.assessed.profile = Some(Profile { stretches, variances });
        self
    }
}

/// By what half the interval of what has those slopes over the free values is stretched to where the likelihood falls as far as its
/// quadratic does over that half.
fn stretch(problem: &Problem, best: &Assessed, slopes: &[f64], sign: f64) -> f64 {
    let half = half_width(best, slopes);
    let across = &best.covariance * DVector::from_column_slice(slopes);
    let variance = across.dot(&DVector::from_column_slice(slopes));
    let way = across * (sign * half / variance);
    if half <= 0.0 || way.iter().any(|by| !by.is_finite()) {
        return 1.0;
    }
    let expected = 0.5 * way.dot(&(&best.information * &way));
    let mut stretch = 1.0_f64;
    for _ in 0..TRIES {
        let Some(fall) = fall(problem, best, &(&way * stretch)).filter(|_| !problem.is_spent()) else { return stretch };
        let next = stretch * (expected / fall.max(f64::MIN_POSITIVE)).sqrt();
        stretch = if next.is_nan() { stretch } else { next.clamp(1.0, MOST_STRETCHED) };
    }
    stretch
}

/// By how much the likelihood falls along a way of the free values; none where it leaves their ranges.
fn fall(problem: &Problem, best: &Assessed, way: &DVector<f64>) -> Option<f64> {
    let mut moved = best.refitted.hypothesis.clone();
    let ranges = ranges(problem, &moved);
    for (((entry, index), range), by) in moved.free().into_iter().zip(ranges).zip(way.iter()) {
        let value = &mut moved.entries[entry].values[index];
        *value += by;
        if *value < range.low || range.high < *value {
            return None;
        }
    }
    let many = moved.told_by(problem);
    let found = evaluate(problem, &moved.physics(&problem.nominal), &best.refitted.noise, 0..many)?;
    Some(best.refitted.log_likelihood - found.fitted(problem))
}
