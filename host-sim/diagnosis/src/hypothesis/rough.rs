//! A number whose likelihood is rough, as a gap's: its neighbours are refitted while they are likelier.

use super::along::by_octaves;
use super::refit::{Refitted, SETTLED, refit};
use crate::problem::Problem;

/// Steps of a neighbour's refit, which ends before where nothing rises any more.
const STEPS: usize = 10;
/// Halvings of the octave to the nearest neighbours; a refit goes on from there with the others held.
const HALVINGS: i32 = 3;

/// With its rough numbers at the top of their profile likelihood; none where they are there, or the entry has none. A refit moves a rough
/// number with all else held, and on a ridge that it shares with the others each holds the other: a gap had been left at 60 % of
/// its width beside a resonance a tenth too low.
pub(super) fn with_likelier_rough(problem: &Problem, from: &Refitted, entry: usize) -> Option<Refitted> {
    let mut best: Option<Refitted> = None;
    for place in from.hypothesis.rough().into_iter().filter(|(at, _)| *at == entry) {
        for octaves in (1..=HALVINGS).map(|halvings| f64::exp2(f64::from(-halvings))) {
            for octaves in [octaves, -octaves] {
                while let Some(found) = likelier(problem, best.as_ref().unwrap_or(from), place, octaves) {
                    best = Some(found);
                }
            }
        }
    }
    best
}

/// Refitted with a number at so many octaves; none where that is not likelier, out of its range, or where no work is left.
fn likelier(problem: &Problem, from: &Refitted, place: (usize, usize), octaves: f64) -> Option<Refitted> {
    let tried = by_octaves(problem, &from.hypothesis, place, octaves).filter(|_| !problem.is_spent())?;
    let found = refit(problem, &tried, &from.noise, STEPS)?;
    (found.log_likelihood - from.log_likelihood >= SETTLED).then_some(found)
}
