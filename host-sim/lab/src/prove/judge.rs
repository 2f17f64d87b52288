//! The answer against the opened seal.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use conceal::seal::{Concealed, Truth};
use serde::{Deserialize, Serialize};

use super::Arm;
use crate::report::{Answer, EffectAnswer, Verdict};

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

/// What came of one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Of the case.
    pub seed: u64,
    /// Arm.
    pub arm: Arm,
    /// Fraction of the clear size.
    pub size: f64,
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
    /// Every concealed effect is named or listed as equivalent.
    pub listed: bool,
    /// A plain `named` for something that was not concealed, and not even a hint of what was.
    pub confidently_wrong: bool,
    /// The answer was to abstain (`none`, `unknown`, `controller`), and so it did.
    pub abstained_right: bool,
    /// Of rightly named effects.
    pub intervals: Vec<Interval>,
    /// Held-out error of the improved model over the noise floor.
    pub heldout_over_floor: f64,
    /// Held-out error over that of the true structure refitted; none where it was not run.
    pub heldout_over_oracle: Option<f64>,
    /// Whether a location overlaps the concealed push; none where there is none.
    pub located: Option<bool>,
    /// Time the diagnosis took, s.
    pub seconds: f64,
}

impl Outcome {
    /// Judges an answer.
    pub fn of(arm: Arm, size: f64, truth: Truth, hash: String, answer: &Answer, seconds: f64) -> Self {
        let named: Vec<String> = answer.effects.iter().map(|effect| effect.id.clone()).collect();
        let equivalent: Vec<String> = answer.effects.iter().flat_map(|effect| effect.equivalent.clone()).collect();
        let concealed: BTreeSet<&str> = truth.effects.iter().map(|effect| effect.id.as_str()).collect();
        let found: BTreeSet<&str> = named.iter().map(String::as_str).collect();
        let hinted = |id: &&str| found.contains(id) || equivalent.iter().any(|other| other == id);
        let nameable = arm.nameable();
        let listed = nameable && concealed.iter().all(|id| hinted(id));
        // An effect that is named without being there, and that is not offered as one way to say what is there.
        let stray = |effect: &EffectAnswer| {
            !concealed.contains(effect.id.as_str())
                && !effect.equivalent.iter().any(|other| concealed.contains(other.as_str()))
        };
        let says = answer.verdict == Verdict::Named;
        let confidently_wrong = says && if nameable { answer.effects.iter().any(stray) } else { !named.is_empty() };
        let right = match arm {
            Arm::Clean | Arm::Decoy => Verdict::None,
            Arm::Controller => Verdict::Controller,
            _ => Verdict::Unknown,
        };
        Self {
            exact: nameable && concealed == found,
            first_right: nameable && named.first().is_some_and(|id| concealed.contains(id.as_str())),
            listed,
            confidently_wrong,
            abstained_right: !nameable && answer.verdict == right,
            intervals: truth.effects.iter().flat_map(|effect| intervals(effect, answer)).collect(),
            heldout_over_floor: answer.fit.heldout_after_rms / answer.fit.noise_floor_rms,
            heldout_over_oracle: None,
            located: located(&truth, answer),
            verdict: answer.verdict,
            seed: truth.seed,
            named,
            equivalent,
            arm,
            size,
            truth,
            hash,
            seconds,
        }
    }

    /// Whether nothing is to be said against it.
    pub fn is_right(&self) -> bool {
        if self.arm.nameable() { self.exact && self.verdict == Verdict::Named } else { self.abstained_right }
    }

    /// What was concealed, in words.
    pub fn concealed(&self) -> String {
        let one = |effect: &Concealed| {
            let values: Vec<String> = effect.parameters.iter().map(|(id, value)| format!("{id} {value:.4}")).collect();
            format!("{} ({})", effect.id, values.join(", "))
        };
        self.truth.effects.iter().map(one).collect::<Vec<_>>().join(" + ")
    }
}

fn intervals(concealed: &Concealed, answer: &Answer) -> Vec<Interval> {
    let Some(effect) = answer.effects.iter().find(|effect| effect.id == concealed.id) else { return Vec::new() };
    let one = |(id, truth): &(String, f64)| {
        let found = effect.parameters.iter().find(|parameter| parameter.id == *id)?;
        // An angle is the same a turn away.
        let turns = if id == "phase_rad" { ((found.value - truth) / TAU).round() * TAU } else { 0.0 };
        let truth = truth + turns;
        Some(Interval {
            parameter: format!("{}.{id}", concealed.id),
            truth,
            value: found.value,
            low: found.low,
            high: found.high,
            holds: found.low <= truth && truth <= found.high,
        })
    };
    concealed.parameters.iter().filter_map(one).collect()
}

fn located(truth: &Truth, answer: &Answer) -> Option<bool> {
    let push = truth.effects.iter().find(|effect| effect.id == "disturbance_pulse")?;
    let value = |id: &str| push.parameters.iter().find(|(name, _)| name == id).map(|(_, value)| *value);
    let start_s = value("start_s")?;
    let end_s = start_s + value("duration_s")?;
    Some(answer.locations.iter().any(|place| place.start_s < end_s && place.end_s > start_s))
}
