//! 95 % intervals of reported values.

use super::information::Assessed;
use crate::problem::Problem;

/// A value with its 95 % interval, in the effect's own unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Smallest relevant size as a share of the typical change that an effect's own file states: of an inertia a thousandth, of a delay
/// 20 us. Less is known of no machine's datasheet.
pub(crate) const SMALLEST_SIZE: f64 = 0.02;

/// Standard normal deviate of a 95 % interval.
pub const TWO_SIDED_95: f64 = 1.959_964;

/// Reported values of an entry with their intervals: the fitted values' covariance through the report, linearised.
pub fn intervals(best: &Assessed, at: usize) -> Vec<Interval> {
    let entry = &best.refitted.hypothesis.entries[at];
    let places = best.refitted.hypothesis.free();
    let own: Vec<usize> = (0..places.len()).filter(|&place| places[place].0 == at).collect();
    (entry.effect.report)(&entry.values)
        .into_iter()
        .zip(slopes(best, at))
        .map(|(value, slopes)| {
            let mut variance = 0.0;
            for &i in &own {
                for &j in &own {
                    variance += slopes[i] * slopes[j] * best.covariance[(i, j)];
                }
            }
            let half = TWO_SIDED_95 * variance.max(0.0).sqrt();
            Interval { value, low: value - half, high: value + half }
        })
        .collect()
}

/// For each reported value of an entry its slope over every free value, in the order of [`crate::hypothesis::Hypothesis::free`].
pub fn slopes(best: &Assessed, at: usize) -> Vec<Vec<f64>> {
    let entry = &best.refitted.hypothesis.entries[at];
    let places = best.refitted.hypothesis.free();
    let mut slopes = vec![vec![0.0; places.len()]; (entry.effect.report)(&entry.values).len()];
    for (place, &(_, index)) in places.iter().enumerate().filter(|(_, (of, _))| *of == at) {
        // A tenth of a standard deviation either way: the report is smooth on that scale.
        let by = 0.1 * best.covariance[(place, place)].max(f64::MIN_POSITIVE).sqrt();
        let moved = |by: f64| {
            let mut values = entry.values.clone();
            values[index] += by;
            (entry.effect.report)(&values)
        };
        for (value, (up, down)) in moved(by).iter().zip(moved(-by)).enumerate() {
            slopes[value][place] = wrapped(up - down) / (2.0 * by);
        }
    }
    slopes
}

/// A phase that passes pi by a small step is no jump.
fn wrapped(difference: f64) -> f64 {
    if difference.abs() > std::f64::consts::PI {
        difference - std::f64::consts::TAU.copysign(difference)
    } else {
        difference
    }
}

impl Assessed {
    /// Whether the interval of one of an entry's leading values leaves out what it is without the effect, by a relevant size.
    pub fn away_from_neutral(&self, problem: &Problem, entry: usize) -> bool {
        let entry_at = &self.refitted.hypothesis.entries[entry];
        let effect = entry_at.effect;
        let neutral = (effect.neutral)(&problem.nominal);
        let ranges = effect.ranges(entry_at.values.len(), &problem.nominal, &problem.excitation);
        let found = intervals(self, entry);
        effect.leading.iter().filter_map(|&at| Some((at, found.get(at)?))).any(|(at, one)| {
            // A value that is fitted by steps of a typical change, and reported as it is fitted, has a size to be measured by.
            let same = entry_at.values.get(at) == Some(&one.value) && effect.parameter(at).free;
            let least = if same { SMALLEST_SIZE * ranges[at].scale } else { 0.0 };
            !(one.low <= neutral && neutral <= one.high) && (one.value - neutral).abs() >= least
        })
    }
}
