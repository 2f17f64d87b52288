//! The counts over all outcomes.

mod parts;

use std::collections::BTreeMap;

use conceal::plan::Arm;
use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ContinuousCDF};

pub use self::parts::{ExperimentScore, Reliability, RivalScore};
use super::judge::{asked, nameable};
use super::power::{self, Curve};
use super::rivals::RIVALS;
use super::run::Ran;
use super::{Outcome, Verdict};

/// A count of a number of cases.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Count {
    /// For which it holds.
    pub holds: usize,
    /// Of these.
    pub of: usize,
}

impl Count {
    /// Counts.
    pub fn over<T>(items: impl IntoIterator<Item = T>, holds: impl Fn(&T) -> bool) -> Self {
        items.into_iter().fold(Self::default(), |count, item| Self {
            holds: count.holds + usize::from(holds(&item)),
            of: count.of + 1,
        })
    }

    /// Share, 1; 0 of nothing.
    pub fn share(self) -> f64 {
        self.holds as f64 / self.of.max(1) as f64
    }

    /// Exact 95 % interval of the share (C. J. Clopper and E. S. Pearson, 1934).
    pub fn interval(self) -> [f64; 2] {
        let (holds, others) = (self.holds as f64, self.of.saturating_sub(self.holds) as f64);
        let bound = |a: f64, b: f64, level: f64| Beta::new(a, b).map(|beta| beta.inverse_cdf(level)).ok();
        let low = bound(holds, others + 1.0, 0.025).filter(|_| self.holds > 0).unwrap_or(0.0);
        let high = bound(holds + 1.0, others, 0.975).filter(|_| self.holds < self.of).unwrap_or(1.0);
        [low, high]
    }
}

/// The counts of one arm. A case without an answer counts as wrong in none of them; see [`Score::failures`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ArmScore {
    /// Arm.
    pub arm: Arm,
    /// Right in every respect, where the size asked for it.
    pub right: Count,
    /// Exact set, where there was something to name, large enough to be asked for.
    pub exact: Count,
    /// First name right, of the same.
    pub first: Count,
    /// First name right or one that no motion tells from it, of the same.
    #[serde(default)]
    pub first_indistinct: Count,
    /// Truth named or offered as equivalent, of the same.
    pub listed: Count,
    /// Abstained where that was right, of the rest.
    pub abstained: Count,
    /// Confidently wrong, at any size.
    pub wrong: Count,
    /// Named anything.
    pub named: Count,
    /// How often each conclusion was drawn.
    pub verdicts: BTreeMap<Verdict, usize>,
    /// `named`, and any of the names is not there.
    pub stray: Count,
    /// `partial`, and the first name is not there; of the partial answers.
    pub partial_wrong: Count,
    /// Named anything that is neither there nor of the log or its noise.
    #[serde(default)]
    pub wrongly: Count,
}

/// One line of the pass line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pass {
    /// What is asked.
    pub what: String,
    /// What must be.
    pub required: String,
    /// What was found; none where no case asked.
    pub measured: Option<f64>,
    /// 95 % interval, where it is a share.
    pub interval: Option<[f64; 2]>,
    /// Of how many.
    pub of: usize,
    /// Whether it is met.
    pub met: bool,
}

/// Everything that is counted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// The pass line.
    pub pass: Vec<Pass>,
    /// By arm.
    pub arms: Vec<ArmScore>,
    /// By effect.
    pub power: Vec<Curve>,
    /// Intervals.
    pub reliability: Reliability,
    /// Of one concealed effect (or nothing): what was answered, how often.
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Median and 95th percentile of the held-out error over the oracle's, and over the floor.
    pub over_oracle: Option<[f64; 2]>,
    /// See above.
    pub over_floor: Option<[f64; 2]>,
    /// Pushes of which the best location covers half, and first regions over the right channel.
    pub located: Count,
    /// See above.
    pub regions: Count,
    /// Before and after.
    pub experiment: ExperimentScore,
    /// On the same files.
    pub rivals: Vec<RivalScore>,
    /// Median and longest time of one diagnosis, s.
    pub seconds: Option<[f64; 2]>,
    /// Seeds that gave no answer, and why.
    pub failures: Vec<(u64, String)>,
}

impl Score {
    /// Counts.
    pub fn of(ran: &Ran) -> Self {
        let outcomes = &ran.outcomes[..];
        let power = power::curves(outcomes);
        let reliability = Reliability::of(outcomes.iter().flat_map(|outcome| &outcome.intervals));
        let over_oracle: Vec<f64> = outcomes.iter().filter_map(|outcome| outcome.heldout_over_oracle).collect();
        let over_floor: Vec<f64> = outcomes.iter().filter_map(|outcome| outcome.heldout_over_floor).collect();
        let mut pass = pass(outcomes, &power, &reliability, &over_oracle);
        let answered = Count { holds: outcomes.len(), of: outcomes.len() + ran.failures.len() };
        pass.push(Pass::share("cases with an answer", "all".to_owned(), answered, |share| share >= 1.0));
        let arms = Arm::ALL.into_iter().filter_map(|arm| ArmScore::of(arm, outcomes)).collect();
        let seconds: Vec<f64> = outcomes.iter().map(|outcome| outcome.seconds).collect();
        Self {
            pass,
            arms,
            power,
            reliability,
            confusion: confusion(outcomes),
            over_oracle: quantiles(over_oracle, [0.5, 0.95]),
            over_floor: quantiles(over_floor, [0.5, 0.95]),
            located: Count::over(outcomes.iter().filter_map(|outcome| outcome.located), |share| *share >= 0.5),
            regions: Count::over(outcomes.iter().filter_map(|outcome| outcome.region_right), |right| *right),
            experiment: ExperimentScore::of(outcomes),
            rivals: RIVALS.iter().map(|rival| RivalScore::of(rival, outcomes)).collect(),
            seconds: quantiles(seconds, [0.5, 1.0]),
            failures: ran.failures.clone(),
        }
    }

    /// Cases with something to be said against them: confidently wrong, not found at twice the detectable size, or not
    /// right in an arm without sizes.
    pub fn misses<'a>(&'a self, outcomes: &'a [Outcome]) -> impl Iterator<Item = &'a Outcome> {
        outcomes.iter().filter(|outcome| {
            let large = asked(&outcome.truth) && (outcome.arm() != Arm::Single || clear(outcome, &self.power));
            outcome.confidently_wrong || large && !outcome.is_right()
        })
    }
}

impl ArmScore {
    fn of(arm: Arm, outcomes: &[Outcome]) -> Option<Self> {
        let all: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.arm() == arm).collect();
        let large = || all.iter().filter(|outcome| asked(&outcome.truth));
        let to_name = || large().filter(|outcome| nameable(&outcome.truth));
        let mut verdicts: BTreeMap<Verdict, usize> = BTreeMap::new();
        all.iter().for_each(|outcome| *verdicts.entry(outcome.verdict).or_default() += 1);
        let partial = all.iter().filter(|outcome| outcome.verdict == Verdict::Partial);
        let score = Self {
            arm,
            right: Count::over(large(), |outcome| outcome.is_right()),
            exact: Count::over(to_name(), |outcome| outcome.exact),
            first: Count::over(to_name(), |outcome| outcome.first_right),
            first_indistinct: Count::over(to_name(), |outcome| outcome.first_indistinct),
            listed: Count::over(to_name(), |outcome| outcome.listed),
            abstained: Count::over(large().filter(|o| !nameable(&o.truth)), |outcome| outcome.abstained_right),
            wrong: Count::over(&all, |outcome| outcome.confidently_wrong),
            named: Count::over(&all, |outcome| outcome.offers_names()),
            verdicts,
            stray: Count::over(&all, |outcome| outcome.stray),
            partial_wrong: Count::over(partial, |outcome| outcome.partial_wrong),
            wrongly: Count::over(&all, |outcome| outcome.wrongly_named),
        };
        (!all.is_empty()).then_some(score)
    }
}

/// Whether a single effect is large enough to be asked for: in the drawn plan at twice the size that the motion can tell, in the
/// fixed one at least twice as strong as what is found in half of the cases; of an effect so hard to
/// find that twice that was not tried, whether it is within a factor of two of the clearest.
fn clear(outcome: &Outcome, power: &[Curve]) -> bool {
    if outcome.truth.machine.is_some() {
        return asked(&outcome.truth);
    }
    let [effect] = &outcome.truth.effects[..] else { return false };
    let Some(curve) = power.iter().find(|curve| curve.id == effect.id) else { return false };
    let strongest = curve.points.last().map_or(0.0, |point| point.strength);
    effect.strength >= (2.0 * curve.at_50.value).min(0.5 * strongest)
}

fn pass(outcomes: &[Outcome], power: &[Curve], reliability: &Reliability, over_oracle: &[f64]) -> Vec<Pass> {
    let of = |arms: &[Arm]| outcomes.iter().filter(|o| arms.contains(&o.arm())).collect::<Vec<_>>();
    let at_most = |what: &str, count: Count, most: f64| {
        Pass::share(what, format!("at most {most}"), count, |share| share <= most)
    };
    let at_least = |what: &str, count: Count, least: f64| {
        Pass::share(what, format!("at least {least}"), count, |share| share >= least)
    };
    let singles: Vec<&Outcome> = of(&[Arm::Single]).into_iter().filter(|outcome| clear(outcome, power)).collect();
    // The tightest bound that two rounds of the drawn plan can show.
    let wrong =
        |what: &str, arm: Arm| at_most(what, Count::over(of(&[arm]), |outcome| outcome.confidently_wrong), 0.02);
    let oracle = quantiles(over_oracle.to_vec(), [0.95, 0.95]).map(|[high, _]| high);
    vec![
        at_most("named on clean data", Count::over(of(&[Arm::Clean]), |outcome| outcome.offers_names()), 0.01),
        Pass::beside(
            "of that wrongly: neither a skew of the log nor the ripple of the noise at its order",
            Count::over(of(&[Arm::Clean]), |outcome| outcome.wrongly_named),
        ),
        at_least(
            "first name right, single effects at twice the detectable size",
            Count::over(&singles, |o| o.first_right),
            0.97,
        ),
        Pass::beside(
            "first name right or one that no motion tells from it",
            Count::over(&singles, |o| o.first_indistinct),
        ),
        at_least("exact pairs", Count::over(of(&[Arm::Pair]).iter().filter(|o| asked(&o.truth)), |o| o.exact), 0.90),
        wrong("confidently wrong with the name taken out of the library", Arm::Removed),
        Pass::beside(
            "of that under a name that no motion tells from the one taken out",
            Count::over(of(&[Arm::Removed]), |outcome| outcome.wrong_indistinct),
        ),
        wrong("confidently wrong with an effect that was never in it", Arm::Outside),
        Pass::share("95 % intervals that hold the truth", "0.93 to 0.97".to_owned(), reliability.all, |share| {
            (0.93..=0.97).contains(&share)
        }),
        Pass {
            what: "held-out error over the oracle's, 95th percentile".to_owned(),
            required: "at most 1.05".to_owned(),
            measured: oracle,
            interval: None,
            of: over_oracle.len(),
            met: oracle.is_some_and(|ratio| ratio <= 1.05),
        },
    ]
}

impl Pass {
    /// A figure beside a line, of which nothing is required.
    fn beside(what: &str, count: Count) -> Self {
        Self { met: true, ..Self::share(what, String::new(), count, |_| true) }
    }

    fn share(what: &str, required: String, count: Count, holds: impl Fn(f64) -> bool) -> Self {
        let any = count.of > 0;
        Self {
            what: what.to_owned(),
            required,
            measured: any.then(|| count.share()),
            interval: any.then(|| count.interval()),
            of: count.of,
            met: any && holds(count.share()),
        }
    }
}

/// Of cases with at most one concealed effect: the answer's first name, or its verdict where it names nothing.
fn confusion(outcomes: &[Outcome]) -> BTreeMap<String, BTreeMap<String, usize>> {
    let mut table: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    let single = |o: &&Outcome| matches!(o.arm(), Arm::Clean | Arm::Single | Arm::Outside) && o.truth.effects.len() < 2;
    for outcome in outcomes.iter().filter(single) {
        let truth = outcome.truth.effects.first().map_or("nothing", |effect| &effect.id);
        let answer = match (&outcome.named[..], outcome.offers_names()) {
            ([first, ..], true) => first.clone(),
            _ => format!("({})", outcome.verdict.name()),
        };
        *table.entry(truth.to_owned()).or_default().entry(answer).or_default() += 1;
    }
    table
}

/// Two quantiles.
fn quantiles(mut values: Vec<f64>, at: [f64; 2]) -> Option<[f64; 2]> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some(at.map(|q| values[(q * last as f64).ceil() as usize]))
}

#[cfg(test)]
pub(in crate::prove) mod testing {
    use conceal::plan::Arm;
    use conceal::seal::Truth;

    /// A truth of an arm with nothing concealed.
    pub(crate) fn truth(arm: Arm) -> Truth {
        let (salt, effects) = (String::new(), Vec::new());
        Truth { seed: 1, arm, decoy: None, effects, torque_noise_nm: 0.0, sensor_noise_rad: 0.0, machine: None, salt }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use conceal::seal::Concealed;

    fn outcome(arm: Arm, strength: f64, verdict: &str, named: &str) -> Outcome {
        let effect =
            Concealed { id: "inertia".to_owned(), in_vocabulary: true, size: 1.0, strength, parameters: Vec::new() };
        let effects = if arm == Arm::Clean { Vec::new() } else { vec![effect] };
        let truth = conceal::seal::Truth { effects, ..testing::truth(arm) };
        let effects = if named.is_empty() { String::new() } else { format!(r#"{{"id": "{named}"}}"#) };
        let answer = format!(r#"{{"verdict": "{verdict}", "effects": [{effects}]}}"#);
        Outcome::of(truth, String::new(), &serde_json::from_str(&answer).unwrap(), 1.0)
    }

    #[test]
    fn the_pass_line_counts_what_it_says() {
        let mut outcomes = vec![outcome(Arm::Clean, 0.0, "none", ""); 99];
        outcomes.push(outcome(Arm::Clean, 0.0, "named", "torque_lag"));
        let found = [0.001, 0.002, 0.004].map(|strength| outcome(Arm::Single, strength, "none", ""));
        outcomes.extend(found);
        outcomes.extend([0.008, 0.016, 0.032].map(|strength| outcome(Arm::Single, strength, "named", "inertia")));
        outcomes.push(outcome(Arm::Outside, 1.0, "named", "inertia"));
        let score = Score::of(&Ran { outcomes: outcomes.clone(), failures: Vec::new() });
        let met: Vec<bool> = score.pass.iter().map(|pass| pass.met).collect();
        assert_eq!(met, [true, true, true, true, false, false, true, false, false, false, true], "{:?}", score.pass);
        // What stands beside the line is no line.
        assert_eq!(score.pass.iter().filter(|pass| pass.required.is_empty()).count(), 3);
        // The name on clean data and the one outside the library; an effect too small to be found is no miss.
        assert_eq!(score.misses(&outcomes).count(), 2);
        assert_eq!(score.confusion["inertia"]["(none)"], 3);
        assert_eq!(score.arms[0].named, Count { holds: 1, of: 100 });
    }

    #[test]
    fn a_share_has_its_interval() {
        let [low, high] = Count { holds: 95, of: 100 }.interval();
        assert!((low - 0.8872).abs() < 1e-4 && (high - 0.9836).abs() < 1e-4, "{low} {high}");
        // None of n: 1 - 0.025^(1/n).
        let [none, most] = Count { holds: 0, of: 64 }.interval();
        assert!(none == 0.0 && (most - (1.0 - 0.025_f64.powf(1.0 / 64.0))).abs() < 1e-9, "{most}");
        assert_eq!(Count { holds: 3, of: 3 }.interval()[1], 1.0);
    }
}
