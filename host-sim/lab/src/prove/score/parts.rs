//! Counts of the intervals, of the arm with an experiment, and of the rivals.

use std::collections::BTreeMap;

use conceal::plan::Arm;
use serde::{Deserialize, Serialize};

use super::Count;
use crate::prove::judge::{After, Interval};
use crate::prove::{Outcome, Verdict};

/// How well intervals hold what they say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reliability {
    /// All of them.
    pub all: Count,
    /// By effect and parameter.
    pub by_parameter: BTreeMap<String, Count>,
    /// Nominal coverage of the interval scaled about its estimate, and the share that then holds the truth.
    pub curve: Vec<(f64, f64)>,
}

/// A rival's counts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RivalScore {
    /// Which.
    pub rival: String,
    /// Named anything on clean data.
    pub named_on_clean: Count,
    /// Exact set of single effects, and of pairs and triples.
    pub exact_single: Count,
    /// See above.
    pub exact_many: Count,
    /// First name right on single effects.
    pub first_single: Count,
    /// Named anything where the effect is outside the library.
    pub named_outside: Count,
}

/// The arm that asks before and after the proposed experiment.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExperimentScore {
    /// Experiments proposed with a reference.
    pub proposed: Count,
    /// `named` and right before.
    pub before: Count,
    /// `named` and right after.
    pub after: Count,
    /// Confidently wrong before.
    pub wrong_before: Count,
    /// Confidently wrong after.
    pub wrong_after: Count,
}

impl Reliability {
    pub(super) fn of<'a>(intervals: impl Iterator<Item = &'a Interval>) -> Self {
        let intervals: Vec<&Interval> = intervals.collect();
        let mut by_parameter: BTreeMap<String, Count> = BTreeMap::new();
        for interval in &intervals {
            let count = by_parameter.entry(interval.parameter.clone()).or_default();
            count.of += 1;
            count.holds += usize::from(interval.holds);
        }
        // Distance of the truth from the estimate, in standard deviations of a normal with this 95 % interval.
        let deviations: Vec<f64> = intervals
            .iter()
            .map(|of| {
                let half = if of.truth < of.value { of.value - of.low } else { of.high - of.value };
                1.96 * (of.truth - of.value).abs() / half.max(f64::MIN_POSITIVE)
            })
            .collect();
        let levels = [(0.5, 0.674), (0.68, 0.994), (0.8, 1.282), (0.9, 1.645), (0.95, 1.96), (0.99, 2.576)];
        let held = |most: f64| Count::over(&deviations, |deviation| **deviation <= most).share();
        Self {
            all: Count::over(&intervals, |interval| interval.holds),
            by_parameter,
            curve: levels.map(|(level, most)| (level, held(most))).to_vec(),
        }
    }
}

impl ExperimentScore {
    pub(super) fn of(outcomes: &[Outcome]) -> Self {
        let poor: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.arm() == Arm::Poor).collect();
        let asked: Vec<&After> = poor.iter().filter_map(|outcome| outcome.after.as_ref()).collect();
        let after = |holds: fn(&After) -> bool| Count::over(&asked, |after| holds(after));
        Self {
            proposed: Count::over(&poor, |outcome| outcome.after.is_some()),
            before: Count::over(&poor, |outcome| outcome.exact && outcome.verdict == Verdict::Named),
            after: after(|after| after.right),
            wrong_before: Count::over(&poor, |outcome| outcome.confidently_wrong),
            wrong_after: after(|after| after.confidently_wrong),
        }
    }
}

impl RivalScore {
    pub(super) fn of(rival: &str, outcomes: &[Outcome]) -> Self {
        let of = |arms: &[Arm]| -> Vec<(&Outcome, &[String])> {
            let asked = outcomes.iter().filter(|outcome| arms.contains(&outcome.arm()));
            let answer = |outcome: &'_ Outcome| outcome.rivals.iter().position(|answer| answer.rival == rival);
            asked.filter_map(|outcome| Some((outcome, &outcome.rivals[answer(outcome)?].named[..]))).collect()
        };
        let truth = |outcome: &Outcome| outcome.truth.effects.iter().map(|e| e.id.clone()).collect::<Vec<_>>();
        let exact = |(outcome, named): &(&Outcome, &[String])| {
            let truth = truth(outcome);
            named.len() == truth.len() && truth.iter().all(|id| named.contains(id))
        };
        let first =
            |(outcome, named): &(&Outcome, &[String])| named.first().is_some_and(|id| truth(outcome).contains(id));
        let any = |(_, named): &(&Outcome, &[String])| !named.is_empty();
        Self {
            rival: rival.to_owned(),
            named_on_clean: Count::over(of(&[Arm::Clean]), any),
            exact_single: Count::over(of(&[Arm::Single]), exact),
            exact_many: Count::over(of(&[Arm::Pair, Arm::Triple]), exact),
            first_single: Count::over(of(&[Arm::Single]), first),
            named_outside: Count::over(of(&[Arm::Removed, Arm::Outside]), any),
        }
    }
}
