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
        let listed = nameable && concealed.iter().all(hinted);
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// An answer that names one effect with an interval for its phase.
    fn answer(verdict: &str, id: &str, equivalent: &str) -> Answer {
        let text = format!(
            r#"{{"schema": 1, "verdict": "{verdict}", "effects": [{{"id": "{id}", "text": "", "equivalent": [{equivalent}],
            "parameters": [{{"id": "phase_rad", "value": 3.1, "low": 3.0, "high": 3.2, "unit": "rad"}}],
            "evidence": {{"heldout_gain": 0.3, "p_value": 0.0, "excess_explained": 1.0}}}}],
            "fit": {{"before_rms": 1, "after_rms": 1, "heldout_before_rms": 1, "heldout_after_rms": 1,
            "noise_floor_rms": 1, "excess_explained": 1, "unit": "rad", "horizon_s": 0.05}},
            "locations": [{{"recording": "a.csv", "start_s": 1.0, "end_s": 1.2, "share": 1.0, "text": ""}}],
            "regions": [], "rejected": [], "experiment": null, "warnings": []}}"#
        );
        serde_json::from_str(&text).unwrap()
    }

    fn judged(arm: Arm, id: &str, parameters: &[(&str, f64)], answer: &Answer) -> Outcome {
        let parameters = parameters.iter().map(|(id, value)| ((*id).to_owned(), *value)).collect();
        let effects = vec![Concealed { id: id.to_owned(), in_vocabulary: true, size: 1.0, parameters }];
        let effects = if id.is_empty() { Vec::new() } else { effects };
        let truth = Truth { seed: 1, effects, torque_noise_nm: 0.0, sensor_noise_rad: 0.0, salt: String::new() };
        Outcome::of(arm, 1.0, truth, String::new(), answer, 0.0)
    }

    #[test]
    fn a_right_name_counts_and_a_phase_a_turn_away_is_the_same() {
        let right =
            judged(Arm::Single, "gravity_load", &[("phase_rad", 3.05 - TAU)], &answer("named", "gravity_load", ""));
        assert!(right.is_right() && right.exact && right.first_right && !right.confidently_wrong);
        assert!(right.intervals.iter().all(|interval| interval.holds) && right.intervals.len() == 1);
        let outside = judged(Arm::Single, "gravity_load", &[("phase_rad", 2.0)], &answer("named", "gravity_load", ""));
        assert!(!outside.intervals[0].holds);
    }

    #[test]
    fn a_wrong_name_is_confident_unless_the_truth_is_offered_beside_it() {
        let wrong = judged(Arm::Single, "inertia", &[], &answer("named", "torque_gain", ""));
        assert!(wrong.confidently_wrong && !wrong.listed && !wrong.is_right());
        let hedged = judged(Arm::Single, "inertia", &[], &answer("named", "torque_gain", "\"inertia\""));
        assert!(!hedged.confidently_wrong && hedged.listed && !hedged.first_right);
        let ambiguous = judged(Arm::Single, "inertia", &[], &answer("ambiguous", "torque_gain", ""));
        assert!(!ambiguous.confidently_wrong && !ambiguous.is_right());
    }

    #[test]
    fn outside_the_library_any_plain_name_is_wrong_and_unknown_is_right() {
        let named = judged(Arm::Outside, "torque_memory", &[], &answer("named", "torque_gain", ""));
        assert!(named.confidently_wrong && !named.abstained_right);
        assert!(judged(Arm::Outside, "torque_memory", &[], &answer("unknown", "torque_gain", "")).is_right());
        assert!(judged(Arm::Clean, "", &[], &answer("named", "torque_gain", "")).confidently_wrong);
        assert!(judged(Arm::Clean, "", &[], &answer("none", "torque_gain", "")).is_right());
    }

    #[test]
    fn a_push_is_located_where_a_span_overlaps_it() {
        let push = |start_s| {
            judged(
                Arm::Single,
                "disturbance_pulse",
                &[("start_s", start_s), ("duration_s", 0.1)],
                &answer("named", "disturbance_pulse", ""),
            )
        };
        assert_eq!((push(1.15).located, push(2.0).located), (Some(true), Some(false)));
    }
}
