//! Values that no derivative tells: the likelihood is searched along each.

use super::Hypothesis;
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

/// With a number that no derivative tells moved by a power of two, all else as it is; none where its range ends.
fn along(problem: &Problem, from: &Refitted, place: (usize, usize), octaves: f64) -> Option<Refitted> {
    at(problem, by_octaves(problem, &from.hypothesis, place, octaves)?, from.noise.clone())
}

/// With a number moved by a power of two; none where its range ends.
pub(super) fn by_octaves(
    problem: &Problem,
    from: &Hypothesis,
    (entry, index): (usize, usize),
    octaves: f64,
) -> Option<Hypothesis> {
    let mut moved = from.clone();
    let of = &mut moved.entries[entry];
    let range = of.effect.ranges(of.values.len(), &problem.nominal, &problem.excitation)[index];
    of.values[index] *= octaves.exp2();
    (range.low..=range.high).contains(&of.values[index]).then_some(moved)
}

/// Variance of the number at a place of [`super::Hypothesis::searched`], the others held, from how far its likelihood falls.
pub(crate) fn variance_along(problem: &Problem, best: &Refitted, place: (usize, usize)) -> f64 {
    let value = best.hypothesis.entries[place.0].values[place.1];
    let fall = |octaves: f64| {
        let falls =
            [octaves, -octaves].map(|by| Some(best.log_likelihood - along(problem, best, place, by)?.log_likelihood));
        let told: Vec<f64> = falls.into_iter().flatten().collect();
        told.iter().sum::<f64>() / told.len().max(1) as f64
    };
    value * value * variance_from(fall)
}

/// Variance, of one at the best value, of a number whose log-likelihood falls by that over so many octaves, from how much further it falls
/// over a step than over half of it. The step is halved while that is more than between half a standard deviation and a whole one,
/// and the median is taken with the next larger and smaller step: a likelihood may be rough, where a sample more or less counts as wrong,
/// and a jump beside its best value is all in one of them.
fn variance_from(mut fall: impl FnMut(f64) -> f64) -> f64 {
    let octaves = |halvings: i32| f64::exp2(f64::from(-halvings));
    let (mut variances, mut before) = (Vec::new(), fall(octaves(0)));
    for halvings in 0..FINEST {
        let next = fall(octaves(halvings + 1));
        let further = (before - next).max(0.0);
        before = next;
        variances.push((octaves(halvings).exp2() - 1.0).powi(2) * OUTER_HALF / further);
        if variances.len() >= 3 && further < OUTER_HALF {
            break;
        }
    }
    let mut around = variances.split_off(variances.len() - 3);
    around.sort_by(f64::total_cmp);
    around[1].min(1.0)
}

/// What a quadratic log-likelihood falls by between half a standard deviation and a whole one.
const OUTER_HALF: f64 = 0.5 - 0.125;

#[cfg(test)]
mod tests {
    use super::variance_from;

    #[test]
    fn a_jump_beside_the_best_value_does_not_narrow_an_interval() {
        for sd in [0.5, 0.04, 1e-4] {
            for (jump, from) in [(0.0, 0.0), (17.0, 0.0), (17.0, 0.6 * sd), (17.0, 3.0 * sd)] {
                let fall = |octaves: f64| {
                    let by = octaves.exp2() - 1.0;
                    0.5 * (by / sd).powi(2) + if by > from { jump } else { 0.0 }
                };
                let found = variance_from(fall).sqrt();
                assert!((0.7..1.5).contains(&(found / sd)), "{found}, not {sd}, with {jump} from {from}");
            }
        }
        assert!((variance_from(|_| 0.0) - 1.0).abs() < 1e-12, "a number that nothing tells");
    }
}
