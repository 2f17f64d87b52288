//! Where the nominal machine fails: in time, and over the channels of state.

mod bootstrap;
mod leftover;
mod order;
mod spans;
mod state;
#[cfg(test)]
mod tests;
mod time;
mod words;

pub use leftover::{Leftover, leftover};
pub use state::{regions, residual_map};
pub use time::{first_unexplained, locations};
