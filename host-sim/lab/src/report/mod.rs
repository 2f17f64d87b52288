//! Last stage: what was found, in words, figures and pictures.

mod answer;
pub mod compare;
pub mod html;
mod improved;
#[cfg(test)]
pub(crate) mod testing;
mod text;
mod units;

pub use answer::{
    AlternativeAnswer, AlternativeEffect, AlternativeValue, Answer, CorrelationAnswer, EffectAnswer, Evidence,
    Experiment, FitAnswer, Interval, Location, PredictorAnswer, Region, Rejected, RemainderAnswer, Verdict,
};
pub use improved::improved_machine;
pub use text::summary;
pub use units::Units;
pub(crate) use units::shown;
