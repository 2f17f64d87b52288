//! The answer against the opened seal.

mod places;

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use conceal::indistinct::indistinct;
use conceal::outside::NAMED_SINCE;
use conceal::plan::Arm;
use conceal::seal::{Concealed, Truth};
use serde::{Deserialize, Serialize};

use self::places::{located, region_right};
use super::answer::{Answer, Named, Verdict};

/// One parameter of a rightly named effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Effect and parameter.
    pub parameter: String,
    /// In the machine.
    pub truth: f64,
    /// Estimate.
    pub value: f64,
    /// 95 % interval.
    pub low: f64,
    /// 95 % interval.
    pub high: f64,
    /// Whether it holds the truth.
    pub holds: bool,
}

/// What a rival named.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RivalAnswer {
    /// Which.
    pub rival: String,
    /// Names, first chosen first.
    pub named: Vec<String>,
    /// Held-out residual torque after over before, 1.
    pub heldout_share: f64,
}

/// What the experiment that the tool proposed led to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct After {
    /// Conclusion with its recordings added.
    pub verdict: Verdict,
    /// Names.
    pub named: Vec<String>,
    /// Exactly the concealed set was `named`.
    pub right: bool,
    /// As [`Outcome::confidently_wrong`].
    pub confidently_wrong: bool,
}

/// What came of one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The seal, opened.
    pub truth: Truth,
    /// SHA-256 of the seal.
    pub hash: String,
    /// The tool's conclusion.
    pub verdict: Verdict,
    /// What it named, by evidence.
    pub named: Vec<String>,
    /// What it calls equivalent to those.
    pub equivalent: Vec<String>,
    /// Exactly the concealed set was named.
    pub exact: bool,
    /// The first name is of the concealed set.
    pub first_right: bool,
    /// The first name is of the concealed set, or one that no motion tells from one of it.
    #[serde(default)]
    pub first_indistinct: bool,
    /// Every concealed effect is named or listed as equivalent.
    pub listed: bool,
    /// `named`, and its first effect is not there.
    pub confidently_wrong: bool,
    /// That, under a name that no motion tells from one of the concealed set.
    #[serde(default)]
    pub wrong_indistinct: bool,
    /// `named`, and any of its effects is not there.
    #[serde(default)]
    pub stray: bool,
    /// `partial`, and its first effect is not there.
    #[serde(default)]
    pub partial_wrong: bool,
    /// It offers names by whatever verdict, and any of them is neither there nor of the log or its noise.
    #[serde(default)]
    pub wrongly_named: bool,
    /// The answer was to abstain (`none`, `unknown`, `controller`), and so it did.
    pub abstained_right: bool,
    /// Of rightly named effects.
    pub intervals: Vec<Interval>,
    /// Held-out error of the improved model over the noise floor.
    pub heldout_over_floor: Option<f64>,
    /// Held-out error over that of the true structure refitted; none where it was not run.
    pub heldout_over_oracle: Option<f64>,
    /// Share of the union of the best location and the concealed event that both cover; none where there is no event.
    pub located: Option<f64>,
    /// Whether the first region is over a channel the concealed effect depends on; none where it depends on none.
    pub region_right: Option<bool>,
    /// After the proposed experiment, in the arm that asks for it; none too where none was proposed.
    pub after: Option<After>,
    /// The rivals on the same files.
    pub rivals: Vec<RivalAnswer>,
    /// Time the diagnosis took, s.
    pub seconds: f64,
}

/// Whether naming what was concealed is the right answer.
pub fn nameable(truth: &Truth) -> bool {
    !truth.effects.is_empty() && !matches!(truth.arm, Arm::Removed | Arm::Outside)
}

fn concealed(truth: &Truth) -> BTreeSet<&str> {
    truth.effects.iter().map(|effect| effect.id.as_str()).collect()
}

/// Orders over position, and frequencies of a tone, that differ by less are one: neighbouring orders up to the fiftieth are told apart.
const SAME_ORDER: f64 = 0.02;
/// How the numbers begin that tell one effect of a kind from another: an order over position, the frequency of a vibration.
const ORDER: &str = "order_per_";
const FREQUENCY: &str = "frequency_hz";

/// Whether a named effect has this order, or frequency; so has one of which the answer gives none.
fn has(named: &Named, number: &str, value: f64) -> bool {
    let mut all = named.parameters.iter().filter(|parameter| parameter.id.starts_with(number));
    let found = all.find_map(|parameter| parameter.value);
    found.is_none_or(|found| (found - value).abs() <= SAME_ORDER * value.abs())
}

/// Whether the order or frequency of what is concealed, where it has one, is that of a name: a ripple of the noise is no cogging of
/// another order, nor a tone a vibration of another frequency.
fn same_order(concealed: &Concealed, named: &Named) -> bool {
    let number = |id: &str| match id {
        FREQUENCY => Some(FREQUENCY),
        _ if id == "order" || id.starts_with(ORDER) => Some(ORDER),
        _ => None,
    };
    let same = |(id, value): &(String, f64)| number(id).is_none_or(|number| has(named, number, *value));
    concealed.parameters.iter().all(same)
}

/// Whether an answer's effect is the concealed one and not another of its kind.
fn is_it(concealed: &Concealed, named: &Named) -> bool {
    concealed.id == named.id && same_order(concealed, named)
}

fn is_concealed(truth: &Truth, named: &Named) -> bool {
    truth.effects.iter().any(|effect| is_it(effect, named))
}

/// Whether an answer's effect is of what is concealed or, by any motion, the same.
fn is_concealed_or_indistinct(truth: &Truth, named: &Named) -> bool {
    is_concealed(truth, named) || truth.effects.iter().any(|effect| indistinct(truth, effect, &named.id))
}

/// What stands for the log or the noise of a drawn machine, or for a kind that has a name since.
fn beside(truth: &Truth, named: &Named) -> bool {
    let of_machine = truth.machine.as_ref().is_some_and(|machine| {
        machine.beside.contains(&named.id)
            // The ripple of the noise is a cogging of its own order and of no other.
            && (named.id != "cogging" || machine.ripple_order.is_none_or(|order| has(named, ORDER, order)))
    });
    let since = |effect: &Concealed| {
        NAMED_SINCE.contains(&(effect.id.as_str(), named.id.as_str())) && same_order(effect, named)
    };
    of_machine || truth.arm == Arm::Outside && truth.effects.iter().any(since)
}

/// Whether an answer may name it without being wrong. Under a name that was taken out, or never was, nothing concealed is there.
fn there(truth: &Truth, named: &Named) -> bool {
    nameable(truth) && is_concealed(truth, named) || beside(truth, named)
}

/// `named` with a first effect that is not there.
fn confidently_wrong(truth: &Truth, answer: &Answer) -> bool {
    answer.verdict == Verdict::Named && answer.effects.first().is_some_and(|first| !there(truth, first))
}

/// Whether the answer names nothing by the verdict that is right; of a log with ripple or skew, whose machine misses nothing, nothing
/// else than these.
fn abstains(truth: &Truth, answer: &Answer) -> bool {
    let right = match truth.arm {
        Arm::Controller => Verdict::Controller,
        Arm::Removed | Arm::Outside => Verdict::Unknown,
        _ => Verdict::None,
    };
    let only_beside = right == Verdict::None
        && matches!(answer.verdict, Verdict::Named | Verdict::Partial)
        && answer.effects.iter().all(|effect| there(truth, effect));
    answer.verdict == right || only_beside
}

/// `partial` with a first effect that is not there.
fn partly_wrong(truth: &Truth, answer: &Answer) -> bool {
    answer.verdict == Verdict::Partial && answer.effects.first().is_some_and(|first| !there(truth, first))
}

/// `named` with any effect that is not there.
fn strays(truth: &Truth, answer: &Answer) -> bool {
    answer.verdict == Verdict::Named && answer.effects.iter().any(|effect| !there(truth, effect))
}

/// Names offered by any verdict of which one is not there.
fn names_wrongly(truth: &Truth, answer: &Answer) -> bool {
    answer.verdict.offers() && answer.effects.iter().any(|effect| !there(truth, effect))
}

/// Smallest size that a drawn case asks to be found, over the detectable one: what is found in half of the cases is asked of none.
const ASKED: f64 = 2.0;

/// Whether all that is concealed is large enough to be asked for. The fixed plan has no detectable sizes: of it all is asked.
pub fn asked(truth: &Truth) -> bool {
    truth.machine.is_none() || truth.effects.iter().all(|effect| effect.size >= ASKED)
}

fn names(answer: &Answer) -> Vec<String> {
    answer.effects.iter().map(|effect| effect.id.clone()).collect()
}

impl After {
    /// Judges the answer with the experiment added.
    pub fn of(truth: &Truth, answer: &Answer) -> Self {
        let named = names(answer);
        let found: BTreeSet<&str> = named.iter().map(String::as_str).collect();
        let right = answer.verdict == Verdict::Named && found == concealed(truth);
        Self { verdict: answer.verdict, right, confidently_wrong: confidently_wrong(truth, answer), named }
    }
}

impl Outcome {
    /// Judges an answer.
    pub fn of(truth: Truth, hash: String, answer: &Answer, seconds: f64) -> Self {
        let named = names(answer);
        let equivalent: Vec<String> = answer.effects.iter().flat_map(|effect| effect.equivalent.clone()).collect();
        // What belongs to the log is no effect of the machine, concealed or not.
        let right = |effect: &Named| is_concealed(&truth, effect);
        let own: Vec<&Named> =
            answer.effects.iter().filter(|effect| right(effect) || !beside(&truth, effect)).collect();
        let found = |one: &Concealed| answer.effects.iter().any(|effect| is_it(one, effect));
        let hinted = |one: &Concealed| found(one) || equivalent.contains(&one.id);
        let nameable = nameable(&truth);
        let wrong = confidently_wrong(&truth, answer);
        let indistinct = |effect: &Named| is_concealed_or_indistinct(&truth, effect);
        let over_floor =
            answer.fit.heldout_after_rms.zip(answer.fit.noise_floor_rms).map(|(after, floor)| after / floor);
        Self {
            exact: nameable && own.iter().all(|effect| right(effect)) && truth.effects.iter().all(found),
            first_right: nameable && own.first().is_some_and(|effect| right(effect)),
            first_indistinct: nameable && own.first().is_some_and(|effect| indistinct(effect)),
            listed: nameable && truth.effects.iter().all(hinted),
            confidently_wrong: wrong,
            wrong_indistinct: wrong && answer.effects.first().is_some_and(indistinct),
            stray: strays(&truth, answer),
            partial_wrong: partly_wrong(&truth, answer),
            wrongly_named: names_wrongly(&truth, answer),
            abstained_right: !nameable && abstains(&truth, answer),
            intervals: truth.effects.iter().flat_map(|effect| intervals(effect, answer)).collect(),
            heldout_over_floor: over_floor.filter(|ratio| ratio.is_finite()),
            heldout_over_oracle: None,
            located: located(&truth, answer),
            region_right: region_right(&truth, answer),
            after: None,
            rivals: Vec::new(),
            verdict: answer.verdict,
            named,
            equivalent,
            truth,
            hash,
            seconds,
        }
    }

    /// Kind of question.
    pub fn arm(&self) -> Arm {
        self.truth.arm
    }

    /// Whether nothing is to be said against it: named exactly, abstained where that was right, or, under motion that
    /// cannot tell, the truth listed among what it could be.
    pub fn is_right(&self) -> bool {
        if nameable(&self.truth) {
            let named = self.exact && self.verdict == Verdict::Named;
            let may_be_open = matches!(self.arm(), Arm::Poor | Arm::Steps);
            named || may_be_open && self.verdict == Verdict::Ambiguous && self.listed
        } else {
            self.abstained_right
        }
    }

    /// Whether it named anything, by whatever verdict that offers names.
    pub fn offers_names(&self) -> bool {
        self.verdict.offers() && !self.named.is_empty()
    }

    /// What was concealed, in words.
    pub fn concealed(&self) -> String {
        let one = |effect: &Concealed| {
            let values: Vec<String> = effect.parameters.iter().map(|(id, value)| format!("{id} {value:.4}")).collect();
            format!("{} ({})", effect.id, values.join(", "))
        };
        let all: Vec<String> = self.truth.effects.iter().map(one).collect();
        if all.is_empty() { "nothing".to_owned() } else { all.join(" + ") }
    }

    /// What was answered, in words.
    pub fn answered(&self) -> String {
        let hints =
            if self.equivalent.is_empty() { String::new() } else { format!(" ~ {}", self.equivalent.join(", ")) };
        let colon = if self.named.is_empty() { "" } else { ": " };
        format!("{}{colon}{}{hints}", self.verdict.name(), self.named.join(" + "))
    }
}

fn intervals(concealed: &Concealed, answer: &Answer) -> Vec<Interval> {
    let Some(effect) = answer.effects.iter().find(|effect| is_it(concealed, effect)) else { return Vec::new() };
    let one = |(id, truth): &(String, f64)| {
        let found = effect.parameters.iter().find(|parameter| parameter.id == *id)?;
        let (value, low, high) = (found.value?, found.low?, found.high?);
        // An angle is the same a turn away.
        let turns = if id == "phase_rad" { ((value - truth) / TAU).round() * TAU } else { 0.0 };
        let truth = truth + turns;
        let parameter = format!("{}.{id}", concealed.id);
        Some(Interval { parameter, truth, value, low, high, holds: low <= truth && truth <= high })
    };
    concealed.parameters.iter().filter_map(one).collect()
}

#[cfg(test)]
mod tests;
