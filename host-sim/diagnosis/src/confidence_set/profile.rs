//! Where the likelihood itself falls as far as its quadratic says: intervals of values that it tells more of one way than the other, as
//! the speed of a Stribeck friction (Venzon and Moolgavkar 1988, along the line on which the quadratic has its own profile).

use std::ops::Range;

use nalgebra::DVector;

use super::Step;
use super::information::Assessed;
use super::intervals::{half_width, slopes, wrapped};
use crate::hypothesis::{OrderSpread, evaluate, order_spread, ranges, variance_along};
use crate::problem::Problem;

/// By what half the intervals of each entry's reported values are stretched downwards and upwards, and the variances of the numbers that
/// no derivative tells.
#[derive(Debug, Clone, Default)]
pub(super) struct Profile {
    stretches: Vec<Vec<[f64; 2]>>,
    variances: Vec<((usize, usize), f64)>,
    /// For each entry what the variance of its order adds to those of its reported values.
    of_orders: Vec<Vec<f64>>,
}

impl Profile {
    pub(super) fn stretch(&self, entry: usize, value: usize) -> [f64; 2] {
        self.stretches.get(entry).and_then(|of| of.get(value)).copied().unwrap_or([1.0; 2])
    }

    /// What an order that is off adds to the variance of a reported value.
    pub(super) fn of_order(&self, entry: usize, value: usize) -> f64 {
        self.of_orders.get(entry).and_then(|of| of.get(value)).copied().unwrap_or(0.0)
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
        let of_orders = (0..hypothesis.entries.len()).map(|at| of_order(problem, best, at)).collect();
        self.assessed.profile = Some(Profile { stretches, variances, of_orders });
        self
    }
}

/// What the variance of an entry's order adds to those of its reported values, all else refitted beside it; as much more as its
/// other values scatter over blocks. Nothing where it has no order or a whole one.
fn of_order(problem: &Problem, best: &Assessed, at: usize) -> Vec<f64> {
    let Some(OrderSpread { variance, step, sides }) = order_spread(problem, &best.refitted, at) else {
        return Vec::new();
    };
    let [below, above] = sides.map(|values| (best.refitted.hypothesis.entries[at].effect.report)(&values));
    let of = |(below, above): (&f64, &f64)| {
        // The order itself is no phase, however far it goes.
        let by = above - below;
        let slope = if (by - 2.0 * step).abs() < 1e-6 * step { 1.0 } else { wrapped(by) / (2.0 * step) };
        slope * slope * variance * best.inflation(at)
    };
    below.iter().zip(&above).map(of).collect()
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

/// By how much the likelihood falls along a way of the free values; none where it leaves their ranges. A recording that is held out tells
/// the values that belong to it alone, as in the information.
fn fall(problem: &Problem, best: &Assessed, way: &DVector<f64>) -> Option<f64> {
    let hypothesis = &best.refitted.hypothesis;
    let alone = hypothesis.alone();
    let mut all = fall_over(problem, best, way, 0..problem.fitted)?;
    for index in problem.fitted..hypothesis.told_by(problem) {
        let own = |at: usize, by: f64| if alone[at] == Some(index) { by } else { 0.0 };
        let own = DVector::from_iterator(way.len(), way.iter().enumerate().map(|(at, by)| own(at, *by)));
        all += fall_over(problem, best, &own, index..index + 1)?;
    }
    Some(all)
}

/// By how much the likelihood of some recordings falls.
fn fall_over(problem: &Problem, best: &Assessed, way: &DVector<f64>, which: Range<usize>) -> Option<f64> {
    let mut moved = best.refitted.hypothesis.clone();
    let ranges = ranges(problem, &moved);
    for (((entry, index), range), by) in moved.free().into_iter().zip(ranges).zip(way.iter()) {
        let value = &mut moved.entries[entry].values[index];
        *value += by;
        if *value < range.low || range.high < *value {
            return None;
        }
    }
    let of = |blocks: &[Vec<f64>]| blocks.iter().flatten().sum::<f64>();
    let found = evaluate(problem, &moved.physics(&problem.nominal), &best.refitted.noise, which.clone())?;
    Some(of(&best.refitted.evaluation.blocks[which]) - of(&found.blocks))
}
