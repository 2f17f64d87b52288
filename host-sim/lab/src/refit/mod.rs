//! The time domain: the improved machine as the plant simulates it, in short windows driven by the recorded commands.

mod model;
mod observer;
mod windows;

pub use model::model;
pub use windows::{HORIZON_S, Windows};
