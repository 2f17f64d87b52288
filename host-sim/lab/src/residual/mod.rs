//! What a model, driven by the recorded commands, leaves unexplained of the recorded position.
//!
//! Tracking error is blind and a replay of the whole recording diverges, as the plant integrates. So the model runs in short
//! windows, and the state each window starts from is estimated.

mod gaps;
mod map;
mod noise;
mod orders;
mod start_state;
#[cfg(test)]
pub(crate) mod testing;
mod unknowns;
mod window;

pub use map::{Bin, Channel, Map};
pub use noise::{sensor_noise, spread_at_rest};
pub use orders::{Order, Orders};
pub use window::{Residual, Window, residual};
