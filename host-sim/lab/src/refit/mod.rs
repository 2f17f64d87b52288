//! The time domain: the improved machine as the plant simulates it, in short windows driven by the recorded commands.

mod descent;
mod model;
mod observer;
mod optimum;
mod point;
mod probe;
mod track;
mod whiten;
mod windows;

pub use model::model;
pub use optimum::TimeFit;
pub use probe::{Event, Probe};
pub(crate) use windows::SETTLE_S;
pub use windows::{COARSEST_S, HORIZON_S, Windows};
