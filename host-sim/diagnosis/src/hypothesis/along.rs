//! Values that no derivative tells: the likelihood is searched along each.

use super::refit::{Refitted, SETTLED, at};
use crate::problem::Problem;

/// Halvings of the step along a number that no derivative tells, after which its likelihood is taken to be flat.
pub(super) const FINEST: i32 = 20;
/// The same where derivatives go on: a thirtieth of an octave, over which a gap's likelihood is a slope again.
pub(super) const FINEST_OF_ROUGH: i32 = 6;

/// Numbers that no derivative tells, each followed up and down while the likelihood rises, in steps that halve until they are
/// small beside what the likelihood tells of the number.
pub(super) fn searched(problem: &Problem, mut best: Refitted, places: &[(usize, usize)], finest: i32) -> Refitted {
    for &place in places {
        for halvings in 1..finest {
            let octaves = f64::exp2(f64::from(-halvings));
            let before = best.log_likelihood;
            let mut change = 0.0_f64;
            for sign in [1.0, -1.0] {
                while let Some(found) = along(problem, &best, place, sign * octaves) {
                    change = change.max((found.log_likelihood - best.log_likelihood).abs());
                    if found.log_likelihood <= best.log_likelihood || problem.is_spent() {
                        break;
                    }
                    best = found;
                }
            }
            if best.log_likelihood - before < SETTLED && change < SETTLED {
                break;
            }
        }
    }
    best
}

/// With a number that no derivative tells moved by a power of two; none where its range ends.
fn along(problem: &Problem, from: &Refitted, (entry, index): (usize, usize), octaves: f64) -> Option<Refitted> {
    let mut tried = from.hypothesis.clone();
    let of = &mut tried.entries[entry];
    let range = of.effect.ranges(of.values.len(), &problem.nominal, &problem.excitation)[index];
    let value = of.values[index] * octaves.exp2();
    of.values[index] = value;
    (range.low <= value && value <= range.high).then(|| at(problem, tried, from.noise.clone())).flatten()
}

/// Variance of the number at a place of [`super::Hypothesis::searched`], the others held, from how far its likelihood falls over the smallest
/// step, of those that are powers of two, over which that is as much as over a standard deviation.
pub(crate) fn variance_along(problem: &Problem, best: &Refitted, place: (usize, usize)) -> f64 {
    let value = best.hypothesis.entries[place.0].values[place.1];
    let fall = |halvings: i32| {
        let octaves = f64::exp2(f64::from(-halvings));
        let falls =
            [octaves, -octaves].map(|by| Some(best.log_likelihood - along(problem, best, place, by)?.log_likelihood));
        let told: Vec<f64> = falls.into_iter().flatten().collect();
        told.iter().sum::<f64>() / told.len().max(1) as f64
    };
    let (mut larger, mut smaller) = ((0, fall(0)), FINEST);
    while smaller - larger.0 > 1 {
        let between = (smaller + larger.0) / 2;
        let of_it = fall(between);
        if of_it >= 0.5 {
            larger = (between, of_it);
        } else {
            smaller = between;
        }
    }
    let step = value * (f64::exp2(f64::exp2(f64::from(-larger.0))) - 1.0);
    step * step / (2.0 * larger.1.max(0.5))
}
