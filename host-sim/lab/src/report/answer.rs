//! The answer as JSON has it (`diagnosis.md`, schema 1).

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
    /// Whether the effects of the answer are believed; else they are what a fit took for want of something better.
    pub fn believes_its_effects(self) -> bool {
        match self {
            Self::None | Self::Named | Self::Partial | Self::Ambiguous | Self::Controller => true,
            Self::Unknown => false,
        }
    }
}

/// The whole answer.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Answer {
    /// 1.
    pub schema: u32,
    /// The conclusion.
    pub verdict: Verdict,
    /// Effects of the best model, by evidence.
    pub effects: Vec<EffectAnswer>,
    /// How well the model fits before and after.
    pub fit: FitAnswer,
    /// Spans of time in which the nominal model fails most.
    pub locations: Vec<Location>,
    /// In each recording the first sample that the nominal model cannot explain.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub first_unexplained: Vec<FirstUnexplained>,
    /// Ranges of state in which it fails most.
    pub regions: Vec<Region>,
    /// What was tried and not taken.
    pub rejected: Vec<Rejected>,
    /// What to record next.
    pub experiment: Option<Experiment>,
    /// What is left and predictable, where something is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remainder: Option<RemainderAnswer>,
    /// What the user should know before believing this.
    pub warnings: Vec<String>,
    /// Residual torque over state, where nothing explains it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub residual_map: Vec<ResidualMap>,
    /// The best sparse formula for what no effect explains, where one predicts held-out data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub formula: Option<Formula>,
    /// The effect that comes closest, where none explains it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub closest: Option<Closest>,
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
    /// Share of the squares of the whitened residual, 1.
    pub share: f64,
    /// Probability of that by chance.
    pub p_value: f64,
    /// Torque (force) that it predicts, root mean square, in the unit of the remainder.
    pub effort_rms: f64,
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
}

/// Evidence of one effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Relative fall of the held-out root mean square that this effect brings, 1.
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
    /// Length of the windows, s.
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

/// The first sample of a recording that noise does not explain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FirstUnexplained {
    /// Name of the recording.
    pub recording: String,
    /// Its row, the first is 1.
    pub row: usize,
    /// s.
    pub t_s: f64,
}

/// An effect that was tried and not taken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rejected {
    /// Identifier.
    pub id: String,
    /// Relative fall of the held-out root mean square it would bring, 1.
    pub heldout_gain: f64,
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

/// Residual torque over one channel.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ResidualMap {
    /// Channel with its unit.
    pub channel: String,
    /// Centres of the bins.
    pub at: Vec<f64>,
    /// Mean residual torque in each bin, N m (N).
    pub mean: Vec<f64>,
    /// Half-width of its 95 % band.
    pub band: Vec<f64>,
    /// Share of the residual's squares that these means predict in blocks they were not taken from, 1; maps are ordered
    /// by it.
    #[serde(default)]
    pub predicts: f64,
}

/// A sum of functions of state that acts on the axis beside the model, N m (N).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Formula {
    /// With values, units and what its letters mean.
    pub text: String,
    /// Its terms, the most telling first.
    pub terms: Vec<FormulaTerm>,
    /// Effects of the best model that it stands beside; empty where it stands beside the nominal model alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub on_top_of: Vec<String>,
    /// Relative fall of the held-out root mean square that it brings to that model, 1.
    pub heldout_gain: f64,
    /// Share of the nominal model's excess over the noise that model and formula explain together, 1.
    pub excess_explained: f64,
}

/// One term of a formula.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FormulaTerm {
    /// The function without its coefficient; a parameter of its own is called p.
    pub text: String,
    /// Its coefficient, or amplitude and phase; then its own parameter, if it has one.
    pub parameters: Vec<Interval>,
}

/// The single effect of the vocabulary that explains most.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Closest {
    /// Identifier.
    pub id: String,
    /// Share of the nominal model's excess over the noise that it alone explains, 1.
    pub excess_explained: f64,
    /// Share that it leaves, 1.
    pub left: f64,
    /// Where it leaves most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<Region>,
    /// In words.
    pub text: String,
}
