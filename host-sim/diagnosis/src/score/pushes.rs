//! Pushes: stretches in which more is missing than chance has missing in any.

use plant::effects::Pulse;

use crate::effects::Span;
use crate::hypothesis::{Hypothesis, Refitted, kept};
use crate::likelihood::inverse::Motion;
use crate::problem::Problem;

use super::orders::MOST;
use super::seek::{Missing, of_recording};

/// Lengths of pushes that are looked for, s.
pub(super) const PUSHES_S: [f64; 7] = [0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64];

/// Lengths of pushes that are told apart: each is twice the one before, and sums over half a window go along with it.
const INDEPENDENT_LENGTHS: usize = 3;

/// Stretches whose missing torque sums to most, for their length, and those that are least likely, best first. A torque that the rotor at
/// rest under this hypothesis does not feel, or that makes the belief lose it, is no large sum.
pub(super) fn pushes(problem: &Problem, missing: &[Missing<'_>]) -> Vec<(usize, Pulse)> {
    let tail = Tail::of(problem);
    let mut found: Vec<(usize, Pulse, f64)> = Vec::new();
    for (recording, one) in missing.iter().enumerate() {
        for sums in sums(problem, one) {
            let places = apart(&sums.sizes, sums.distance);
            let Some(&best) = places.first() else { continue };
            let duration_s = sums.many as f64 * one.period_s();
            let pulse = Pulse { start_s: one.t_s[best], duration_s, amplitude: sums.signs[best].signum() };
            let sizes: Vec<f64> = places.iter().map(|&at| sums.sizes[at]).collect();
            found.push((recording, pulse, tail.chance(&sizes)));
        }
    }
    found.sort_by(|a, b| a.2.total_cmp(&b.2));
    found.into_iter().take(MOST).map(|(recording, pulse, _)| (recording, pulse)).collect()
}

/// Probability that chance alone has as much missing in any stretch as is missing, without its push, where an event is. Beside it stand the
/// other stretches in which most is missing: where the motion is predicted, when the push is there. What an event leaves
/// behind it, while the belief that it misled comes back, is no chance, and the push takes it along; a motion that is given is misled by nothing.
pub(crate) fn by_chance(problem: &Problem, without: &Hypothesis, with: &Refitted, event: Span) -> f64 {
    let (recording, from_s, to_s) = event;
    let sums_of = |of: &Hypothesis| {
        let path = kept(problem, &of.physics(&problem.nominal), &with.noise, recording + 1)?;
        Some(sums(problem, &of_recording(problem, &path, recording, &path.recordings[recording])))
    };
    let tail = Tail::of(problem);
    let Some(before) = sums_of(without) else { return 1.0 };
    let beside = match tail {
        Tail::Exponential => sums_of(&with.hypothesis),
        Tail::Heavy => Some(before.clone()),
    };
    let Some(beside) = beside else { return 1.0 };
    let rows = problem.recordings[recording].rows_between(from_s, to_s);
    let chance = |(before, mut beside): (Sums, Sums)| {
        let meets = rows.start.saturating_sub(before.many)..rows.end.min(before.sizes.len());
        let of_the_event = before.sizes.get(meets.clone())?.iter().copied().reduce(f64::max)?;
        let near = meets.start.saturating_sub(beside.distance)..(meets.end + beside.distance).min(beside.sizes.len());
        beside.sizes[near].fill(0.0);
        let others = apart(&beside.sizes, beside.distance).into_iter().take(TAIL).map(|at| beside.sizes[at]);
        let sizes: Vec<f64> = std::iter::once(of_the_event).chain(others.filter(|size| *size > 0.0)).collect();
        Some(tail.chance(&sizes))
    };
    let least = before.into_iter().zip(beside).filter_map(chance).fold(1.0, f64::min);
    // An event stands out in a stretch of one length, and how long it is the likelihood knows better.
    let tried = tail.kinds_of_sum() * problem.fitted * INDEPENDENT_LENGTHS;
    (least * tried as f64).min(1.0)
}

/// Sums of what is missing in one recording over windows of one length.
#[derive(Clone)]
struct Sums {
    /// Rows of a window.
    many: usize,
    /// Rows beyond which two windows tell of different stretches.
    distance: usize,
    /// How much is missing in each.
    sizes: Vec<f64>,
    /// With the sign of the missing torque.
    signs: Vec<f64>,
}

/// Over windows of all lengths: of the missing torque, and where the motion is predicted of how unlikely the rows are.
fn sums(problem: &Problem, one: &Missing<'_>) -> Vec<Sums> {
    let torque = Summed::of(one.torque.iter().copied());
    let unlikely = Summed::of(one.misfit.iter().map(|of| of.0));
    let signed = Summed::of(one.misfit.iter().map(|of| of.1));
    // Test functions smear a push over their own support, and only they do.
    let smeared = (problem.motions.first().map_or(0.0, Motion::support_s) / one.period_s()).ceil() as usize;
    let of_length = |length_s: f64| {
        let many = (length_s / one.period_s()).round() as usize;
        let sums = |sizes, signs| Sums { many, distance: many + many / 2 + smeared, sizes, signs };
        let torques = torque.windows(many);
        let of_torque = sums(torques.iter().map(|sum| sum.abs()).collect(), torques);
        let of_misfit = (!one.misfit.is_empty()).then(|| sums(unlikely.windows(many), signed.windows(many)));
        let long_enough = many >= 2 && 4 * many <= one.torque.len();
        [long_enough.then_some(of_torque), of_misfit.filter(|_| long_enough)]
    };
    PUSHES_S.into_iter().flat_map(of_length).flatten().collect()
}

/// Sums from the first of some values to each.
struct Summed(Vec<f64>);

impl Summed {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut sums = vec![0.0];
        for value in values {
            sums.push(sums[sums.len() - 1] + value);
        }
        Self(sums)
    }

    /// The sum of every so many neighbours.
    fn windows(&self, many: usize) -> Vec<f64> {
        self.0.iter().zip(self.0.iter().skip(many)).map(|(from, to)| to - from).collect()
    }
}

/// Places of the largest sums that are more than that many rows apart, largest first.
fn apart(windows: &[f64], rows: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..windows.len()).collect();
    order.sort_by(|a, b| windows[*b].total_cmp(&windows[*a]));
    let mut kept: Vec<usize> = Vec::new();
    for index in order {
        if kept.iter().all(|other| index.abs_diff(*other) > rows) {
            kept.push(index);
        }
        if kept.len() == TAIL + 1 {
            break;
        }
    }
    kept
}

/// Most extremes that the tail is fitted to.
const TAIL: usize = 12;

/// What chance has at most.
#[derive(Debug, Clone, Copy)]
enum Tail {
    /// Where the motion is predicted.
    Exponential,
    /// Where it is given.
    Heavy,
}

impl Tail {
    fn of(problem: &Problem) -> Self {
        if problem.motions.is_empty() { Self::Exponential } else { Self::Heavy }
    }

    /// Kinds of sum that are looked at: of the missing torque, and of what is unlikely.
    fn kinds_of_sum(self) -> usize {
        match self {
            Self::Exponential => 2,
            Self::Heavy => 1,
        }
    }

    /// Probability that chance has the first of some extremes that far beyond the second, with their sizes, the others largest first.
    fn chance(self, sizes: &[f64]) -> f64 {
        match self {
            Self::Exponential => of_an_exponential_tail(sizes),
            Self::Heavy => of_a_heavy_tail(sizes),
        }
    }
}

/// Where the motion is given, all that the model leaves stands in for noise: its tail is heavy, as Hill's estimator (1975) fits it, so
/// that it has no events for its own. It takes the fitted tail for the true one and asks for all of [`TAIL`].
fn of_a_heavy_tail(sizes: &[f64]) -> f64 {
    if sizes.len() < TAIL + 1 {
        return 1.0;
    }
    let last = sizes[TAIL].max(f64::MIN_POSITIVE);
    let logs: f64 = sizes[1..TAIL].iter().map(|size| (size / last).ln()).sum();
    let tail_index = (TAIL - 1) as f64 / logs.max(1e-9);
    (sizes[0] / sizes[1].max(f64::MIN_POSITIVE)).powf(-tail_index)
}

/// Where the motion is predicted, noise is what moves it and the tail of its sums is no heavier than an exponential. Spacings of an exponential
/// tail's order statistics, each times its rank, are independent of one mean (Renyi 1953), so that the first over the mean of `k`
/// others is an F of 2 and 2k degrees of freedom.
fn of_an_exponential_tail(sizes: &[f64]) -> f64 {
    let Some((last, before)) = sizes.split_last().filter(|_| sizes.len() > 2) else { return 1.0 };
    let others = before.len() - 1;
    let spacings: f64 = before[1..].iter().map(|size| size - last).sum::<f64>() + before[1] - last;
    let over_the_mean = (before[0] - before[1]) / spacings.max(f64::MIN_POSITIVE);
    (1.0 + over_the_mean).powi(-(others as i32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_that_is_far_beyond_an_exponential_tail_is_no_chance() {
        // Spacings of one mean: the first is as long as the others.
        let sizes: Vec<f64> =
            (1..=13).map(|rank| (1..rank).map(|of| -1.0 / f64::from(of)).sum::<f64>() + 4.0).collect();
        let ordinary = of_an_exponential_tail(&sizes);
        // A spacing of the mean has the chance (1 + 1/11)^-11.
        assert!((ordinary - (1.0_f64 + 1.0 / 11.0).powi(-11)).abs() < 1e-12, "{ordinary}");
        let far = of_an_exponential_tail(&[&[sizes[0] + 30.0], &sizes[1..]].concat());
        assert!(far < 1e-5, "{far}");
    }

    #[test]
    fn few_others_make_nothing_certain() {
        assert_eq!(of_an_exponential_tail(&[9.0, 1.0]), 1.0);
        assert!(of_an_exponential_tail(&[9.0, 1.0, 0.5]) > 0.05);
        assert_eq!(of_a_heavy_tail(&[9.0, 1.0, 0.5]), 1.0);
    }

    #[test]
    fn a_heavy_tail_has_no_event_where_an_exponential_one_has() {
        let mut sizes: Vec<f64> = (1..=13).map(|rank| 1.0 / f64::from(rank)).collect();
        sizes[0] = 3.0;
        assert!(of_a_heavy_tail(&sizes) > 0.01 && of_an_exponential_tail(&sizes) < of_a_heavy_tail(&sizes));
    }
}
