//! Last stage: what was found, in words, figures and pictures.

mod answer;
pub mod compare;
pub mod html;
mod improved;
mod text;
mod units;

pub use answer::{
    Answer, Closest, EffectAnswer, Evidence, Experiment, FirstUnexplained, FitAnswer, Formula, FormulaTerm, Interval,
    Location, PredictorAnswer, Region, Rejected, RemainderAnswer, ResidualMap, Verdict,
};
pub use improved::improved_machine;
pub use text::summary;
pub use units::Units;
