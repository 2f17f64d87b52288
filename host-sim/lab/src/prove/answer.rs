//! What the proof reads of an answer: its JSON as the specification has it, whatever made it.

use serde::{Deserialize, Serialize};

/// The conclusion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Nothing is missing.
    None,
    /// This is it.
    Named,
    /// These are certain, and something predictable is left.
    Partial,
    /// The data cannot choose.
    Ambiguous,
    /// Something outside the vocabulary.
    Unknown,
    /// Not the law in the machine file.
    Controller,
}

impl Verdict {
    /// Whether it offers what is named, to be believed or to be chosen from.
    pub fn offers(self) -> bool {
        matches!(self, Self::Named | Self::Partial | Self::Ambiguous)
    }

    /// As in the answer.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Named => "named",
            Self::Partial => "partial",
            Self::Ambiguous => "ambiguous",
            Self::Unknown => "unknown",
            Self::Controller => "controller",
        }
    }
}

/// An answer.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Answer {
    /// The conclusion.
    pub verdict: Verdict,
    /// By evidence.
    #[serde(default)]
    pub effects: Vec<Named>,
    /// Fit before and after.
    #[serde(default)]
    pub fit: Fit,
    /// Spans of time.
    #[serde(default)]
    pub locations: Vec<Location>,
    /// Ranges of state.
    #[serde(default)]
    pub regions: Vec<Region>,
    /// What to record next.
    #[serde(default)]
    pub experiment: Option<Experiment>,
}

/// One effect.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Named {
    /// Identifier.
    pub id: String,
    /// What the data cannot tell from it.
    #[serde(default)]
    pub equivalent: Vec<String>,
    /// Values with their intervals.
    #[serde(default)]
    pub parameters: Vec<Estimate>,
}

/// A value with its 95 % interval.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Estimate {
    /// Parameter.
    pub id: String,
    /// Estimate; none where the answer has no number.
    pub value: Option<f64>,
    /// Lower end.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

/// Root mean squares of the fit.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct Fit {
    /// Nominal model, held out.
    pub heldout_before_rms: Option<f64>,
    /// Improved model, held out.
    pub heldout_after_rms: Option<f64>,
    /// Noise alone.
    pub noise_floor_rms: Option<f64>,
    /// Of these.
    #[serde(default)]
    pub unit: String,
}

/// A span of time in a recording.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Location {
    /// Recording.
    pub recording: String,
    /// s.
    pub start_s: f64,
    /// s.
    pub end_s: f64,
}

/// A range of one channel.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Region {
    /// Channel with its unit.
    pub channel: String,
}

/// What to record next.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Experiment {
    /// Its reference, where one was written; relative to where the diagnosis ran.
    #[serde(default)]
    pub reference_csv: Option<String>,
}
