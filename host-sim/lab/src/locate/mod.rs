//! Where the nominal machine fails: in time, and over the channels of state.

mod leftover;
mod state;
mod time;

pub use leftover::{Leftover, leftover};
pub use state::{regions, residual_map};
pub use time::locations;
