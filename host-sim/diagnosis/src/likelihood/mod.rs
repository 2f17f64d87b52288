//! The one judge of fit: how likely a recording is under a hypothesis.

mod acting;
mod along;
mod belief;
pub(crate) mod filter;
mod gaussian;
pub(crate) mod inverse;
mod noise;

pub use acting::{Acting, Grid};
pub(crate) use along::{MissingTorque, Window};
pub use filter::Innovations;
pub use noise::Noise;
pub(crate) use noise::Rounding;
