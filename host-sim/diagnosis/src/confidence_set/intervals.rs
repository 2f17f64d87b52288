//! 95 % intervals of reported values.

use nalgebra::DVector;

use super::information::Assessed;
use crate::hypothesis::Entry;
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

impl Interval {
    /// What of it physics allows: a duration, a lag or a gap is never below zero, however little is known of it.
    fn possible(self, entry: &Entry) -> Self {
        let mut fitted = entry.values.iter().zip(entry.effect.parameters);
        let never_negative = fitted.any(|(fitted, of)| *fitted == self.value && of.low >= 0.0);
        Self { low: if never_negative { self.low.max(0.0) } else { self.low }, ..self }
    }
}

/// Smallest relevant size as a share of the typical change that an effect's own file states: of an inertia a thousandth, of a delay
/// 20 us. Less is known of no machine's datasheet.
pub(crate) const SMALLEST_SIZE: f64 = 0.02;

/// Standard normal deviate of a 95 % interval.
pub const TWO_SIDED_95: f64 = 1.959_964;

/// Critical value of a two-sided 95 % interval whose variance was estimated over so many blocks with a Bartlett window of that many
/// lags: few blocks make that variance small and uncertain at once (Kiefer and Vogelsang 2005, Econometric Theory 21, table 1).
pub fn critical_value(blocks: usize, lags: usize) -> f64 {
    let share = ((lags + 1) as f64 / blocks.max(1) as f64).min(1.0);
    TWO_SIDED_95 + share * (2.9694 + share * (0.4160 - share * 0.5324))
}

/// Reported values of an entry with their intervals: the fitted values' covariance through the report, linearised, and stretched to
/// where the likelihood falls as far as that says. To that comes the smallest relevant size, as a scatter of its own: of another way to
/// integrate the same machine no model knows more.
pub fn intervals(best: &Assessed, at: usize) -> Vec<Interval> {
    let entry = &best.refitted.hypothesis.entries[at];
    let slopes = slopes(best, at);
    let one = |(index, value): (usize, f64)| {
        let half = match best.profile.as_ref().and_then(|profile| profile.variance(at, index)) {
            Some(variance) => TWO_SIDED_95 * variance.sqrt(),
            None => half_width(best, &slopes[index]),
        };
        let of_order = best.profile.as_ref().map_or(0.0, |profile| profile.of_order(at, index));
        let half = half.hypot(best.critical_value() * of_order.sqrt());
        let [down, up] = best.profile.as_ref().map_or([1.0; 2], |profile| profile.stretch(at, index));
        let least = smallest(best, at, &slopes[index]);
        Interval { value, low: value - (half * down).hypot(least), high: value + (half * up).hypot(least) }
            .possible(entry)
    };
    (entry.effect.report)(&entry.values).into_iter().enumerate().map(one).collect()
}

/// Half the 95 % interval of what has those slopes over the free values.
pub(super) fn half_width(best: &Assessed, slopes: &[f64]) -> f64 {
    let slopes = DVector::from_column_slice(slopes);
    best.critical_value() * slopes.dot(&(&best.covariance * &slopes)).max(0.0).sqrt()
}

/// What the smallest relevant sizes of an entry's own free values make of a reported value with those slopes.
fn smallest(best: &Assessed, at: usize, slopes: &[f64]) -> f64 {
    let places = best.refitted.hypothesis.free();
    let of = places.iter().zip(slopes).zip(&best.smallest).filter(|(((of, _), _), _)| *of == at);
    of.map(|((_, slope), smallest)| (slope * smallest).powi(2)).sum::<f64>().sqrt()
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
pub(super) fn wrapped(difference: f64) -> f64 {
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
        let (found, slopes) = (intervals(self, entry), slopes(self, entry));
        effect.leading.iter().filter_map(|&at| Some((at, found.get(at)?))).any(|(at, one)| {
            let relevant = (one.value - neutral).abs() >= smallest(self, entry, &slopes[at]);
            relevant && !(one.low <= neutral && neutral <= one.high)
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use nalgebra::{DMatrix, DVector};
    use plant::sensor::TorqueNoise;

    use super::super::information::{LAGS, add_spread};
    use super::{Interval, critical_value};
    use crate::effects::find;
    use crate::hypothesis::Entry;

    /// A push whose end nothing shows, as it meets a rotor that friction holds: its size may be negative, its duration not.
    #[test]
    fn an_interval_ends_where_physics_does() {
        let push = Entry { effect: find("disturbance_pulse").unwrap(), values: vec![0.0, 3.1, 0.08, 0.01] };
        let reported = [(0.08, 0.0), (0.01, -0.2)];
        for (value, low) in reported {
            let found = Interval { value, low: value - 0.21, high: value + 0.21 }.possible(&push);
            assert!((found.low - low).abs() < 1e-12 && found.high == value + 0.21, "{found:?}");
        }
    }

    /// 2000 times 24 independent block scores of one value, as of two recordings of 3 s: what is estimated has them sum to zero.
    #[test]
    fn intervals_from_few_blocks_hold_the_truth() {
        let mut noise = TorqueNoise::new(1.0, 7).unwrap();
        let (rounds, blocks) = (2000, 24);
        let mut held = [0_usize; 2];
        for _ in 0..rounds {
            let scores: Vec<f64> = (0..blocks).map(|_| noise.draw()).collect();
            let sum: f64 = scores.iter().sum();
            let centred: Vec<DVector<f64>> =
                scores.iter().map(|score| DVector::from_element(1, score - sum / blocks as f64)).collect();
            let mut spread = DMatrix::zeros(1, 1);
            centred.chunks(blocks / 2).for_each(|recording| add_spread(&mut spread, recording));
            let sd = (spread[(0, 0)] * blocks as f64 / (blocks as f64 - 1.0)).sqrt();
            for (held, deviate) in held.iter_mut().zip([critical_value(blocks, LAGS), super::TWO_SIDED_95]) {
                *held += usize::from(sum.abs() <= deviate * sd);
            }
        }
        let [held, by_normal] = held.map(|held| held as f64 / f64::from(rounds));
        assert!((0.93..0.97).contains(&held) && by_normal < 0.93, "{held}, {by_normal} with the normal deviate");
    }
}
