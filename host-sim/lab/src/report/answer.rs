//! The answer as JSON has it (`diagnosis.md`, schema 2).

use serde::{Deserialize, Serialize};

/// What the tool concludes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Nothing is missing beyond the noise floor.
    #[default]
    None,
    /// This is it.
    Named,
    /// Something is missing and the data cannot choose.
    Ambiguous,
    /// Some of what is missing is certain, and something predictable is left.
    Partial,
    /// Something is missing and nothing in the vocabulary explains it.
    Unknown,
    /// The recorded commands are not what the control law computes.
    Controller,
}

impl Verdict {
    /// Whether what is named is certain, be it all or only some of what is missing.
    pub fn is_certain(self) -> bool {
        matches!(self, Self::Named | Self::Partial)
    }

    /// As in the JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Named => "named",
            Self::Ambiguous => "ambiguous",
            Self::Partial => "partial",
            Self::Unknown => "unknown",
            Self::Controller => "controller",
        }
    }
}

/// The whole answer.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Answer {
    /// 2.
    pub schema: u32,
    /// The conclusion.
    pub verdict: Verdict,
    /// Effects of the best model, by evidence.
    pub effects: Vec<EffectAnswer>,
    /// How well the model fits before and after.
    pub fit: FitAnswer,
    /// Spans of time in which the nominal model fails most.
    pub locations: Vec<Location>,
    /// Ranges of state in which it fails most.
    pub regions: Vec<Region>,
    /// What was tried and not taken.
    pub rejected: Vec<Rejected>,
    /// What to record next.
    pub experiment: Option<Experiment>,
    /// Models that these recordings do not exclude beside the best one though another motion may, by their likelihood.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<AlternativeAnswer>,
    /// How the errors of the values of `effects` go together; none with fewer than two of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correlation: Option<CorrelationAnswer>,
    /// What is left and predictable, where something is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remainder: Option<RemainderAnswer>,
    /// What the user should know before believing this.
    pub warnings: Vec<String>,
}

impl Answer {
    /// Whether it has more than one thing that may be what is missing.
    pub(crate) fn offers_a_choice(&self) -> bool {
        let [one] = &self.effects[..] else { return !self.effects.is_empty() };
        !(one.equivalent.is_empty() && one.nuisances.is_empty() && self.alternatives.is_empty())
    }
}

/// A model that these recordings do not exclude.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AlternativeAnswer {
    /// All of its effects, each with the values that it has in this model.
    pub effects: Vec<AlternativeEffect>,
}

/// An effect of an alternative.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AlternativeEffect {
    /// Identifier of the vocabulary.
    pub id: String,
    /// Its values.
    pub parameters: Vec<AlternativeValue>,
    /// The recording it happens in, for events.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
}

/// A value of an alternative, which has no interval of its own.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AlternativeValue {
    /// Identifier of the parameter, its unit last.
    pub id: String,
    /// Estimate.
    pub value: f64,
    /// Unit.
    pub unit: String,
}

/// Correlation of the errors of fitted values.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CorrelationAnswer {
    /// `effect.parameter` of each row and column; the second entry of an effect is `effect#2.parameter`.
    pub values: Vec<String>,
    /// -1 to 1, symmetric, 1 on the diagonal.
    pub matrix: Vec<Vec<f64>>,
}

/// What the best model leaves and a channel predicts. The values of the effects may have absorbed some of it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RemainderAnswer {
    /// Torque (force) that the noise has to stand in for, root mean square.
    pub effort_rms: f64,
    /// Its unit.
    pub unit: String,
    /// Effects that would certainly add to the likelihood, but too little to the motion to be named.
    pub unnamed: Vec<String>,
    /// Channels that predict part of it on data they were not fitted to, best first.
    pub predictors: Vec<PredictorAnswer>,
}

/// How much of the remainder one channel predicts.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PredictorAnswer {
    /// Channel with its unit.
    pub channel: String,
    /// Share of the squares of the whitened residual, beyond what chance takes, 1.
    pub share: f64,
    /// Probability of that by chance.
    pub p_value: f64,
    /// Torque (force) that it predicts, root mean square, in the unit of the remainder; null where what it predicts is none, as a
    /// memory of the noise.
    pub effort_rms: Option<f64>,
}

/// One effect of the best model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectAnswer {
    /// Identifier of the vocabulary.
    pub id: String,
    /// One sentence: what it is, where it usually comes from.
    pub text: String,
    /// Effects that these recordings cannot tell from it, best first.
    pub equivalent: Vec<String>,
    /// What explains the recordings as well and is no effect of the vocabulary, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nuisances: Vec<String>,
    /// Values in the improved model.
    pub parameters: Vec<Interval>,
    /// Why it is believed.
    pub evidence: Evidence,
    /// The recording it happens in, for events.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
}

/// A value with its 95 % interval.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Identifier of the parameter, its unit last.
    pub id: String,
    /// Estimate.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end of the 95 % interval.
    pub high: f64,
    /// Unit.
    pub unit: String,
    /// What the nominal model has in its place; none where that is nothing, or nothing that one value says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal: Option<f64>,
}

/// Evidence of one effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Share of the held-out root mean square without this effect that it accounts for, by what predictions with and without it differ, 1.
    pub heldout_gain: f64,
    /// Corrected for every variant tried.
    pub p_value: f64,
    /// Share of the excess over the floor that this effect alone removes from the model without it, 1.
    pub excess_explained: f64,
}

/// Residual before and after.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FitAnswer {
    /// Nominal model, on what was fitted.
    pub before_rms: f64,
    /// Improved model, on what was fitted.
    pub after_rms: f64,
    /// Nominal model, on what was held out.
    pub heldout_before_rms: f64,
    /// Improved model, on what was held out.
    pub heldout_after_rms: f64,
    /// What noise alone would leave of what was fitted.
    pub noise_floor_rms: f64,
    /// What noise alone would leave of what was held out.
    pub heldout_floor_rms: f64,
    /// Share of the excess over the floor that is explained, 1.
    pub excess_explained: f64,
    /// Unit of the residuals.
    pub unit: String,
    /// Length of the windows, s: 0.05, or eight rows where those are longer; of recordings that differ, the longest.
    pub horizon_s: f64,
}

/// A span of time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Location {
    /// Name of the recording.
    pub recording: String,
    /// s.
    pub start_s: f64,
    /// s.
    pub end_s: f64,
    /// Share of the excess, 1.
    pub share: f64,
    /// Lower end of the share's 95 % band.
    pub share_low: f64,
    /// Upper end of the share's 95 % band.
    pub share_high: f64,
    /// What happens there.
    pub text: String,
}

/// A range of one channel of state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Channel with its unit.
    pub channel: String,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Share of the excess, 1.
    pub share: f64,
    /// Lower end of the share's 95 % band.
    pub share_low: f64,
    /// Upper end of the share's 95 % band.
    pub share_high: f64,
}

/// An effect that was tried and not taken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rejected {
    /// Identifier.
    pub id: String,
    /// Share of the held-out root mean square that it would account for, 1; none where its log-likelihood is not worth its values.
    pub heldout_gain: Option<f64>,
    /// Why not.
    pub why: String,
}

/// What to record next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// In words.
    pub text: String,
    /// What it tells apart.
    pub separates: Vec<String>,
    /// The reference to play, where one was written.
    pub reference_csv: Option<String>,
}
