//! Linear stability of the servo (section V of the paper) by four methods, and what the loop tolerates.
//!
//! [`curves`] is the paper's: the boundary in the plane of the gains, here with the count of unstable roots on either
//! side. [`argument`], [`spectrum`] and [`sampled`] share nothing with it but the equation.

#[cfg(test)]
mod agreement;
pub mod analysis;
pub mod argument;
pub mod case;
mod chebyshev;
pub mod curves;
pub mod describing;
pub mod limits;
pub mod region;
pub mod sampled;
pub mod spectrum;
#[cfg(test)]
mod testing;
mod zeros;

pub use case::{Fluid, Gains, Loop, LoopError, NormalisedGains, Plant};
