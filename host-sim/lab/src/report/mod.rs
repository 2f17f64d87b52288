//! The answer: what is missing, how sure that is, and what was looked at.

mod answer;
mod text;

pub use answer::{
    Answer, EffectAnswer, Evidence, Experiment, FitAnswer, Interval, Location, Region, Rejected, ResidualMap, Verdict,
};
pub use text::summary;
