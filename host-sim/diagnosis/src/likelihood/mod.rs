//! The one judge of fit: how likely a recording is under a hypothesis.

mod acting;
mod along;
mod belief;
mod commands;
pub(crate) mod filter;
mod gaussian;
mod grid;
pub(crate) mod inverse;
mod noise;

pub use acting::{Acting, Lately};
pub(crate) use along::Window;
pub use filter::Innovations;
pub use grid::Grid;
pub(crate) use noise::Rounding;
pub use noise::{Colour, Noise};
