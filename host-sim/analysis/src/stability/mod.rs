//! Linear stability of the servo (section V of the paper) by four methods, and what the loop tolerates.
//!
//! [`curves`] is the paper's: the boundary in the plane of the gains, here with the count of unstable roots on either
//! side. [`argument`], [`spectrum`] and [`sampled`] share nothing with it but the equation.
//!
//! The three methods of the continuous loop agree on the number of unstable roots, and one part in a million on either
//! side of the boundary on the verdict. The sampled loop is another loop, later by half a control period for each hold;
//! it agrees with the continuous loop that has those delays ([`sampled::held_equivalent`]) but for held torques within
//! 1 % of the boundary. The test `agreement` draws 2,000 loops to hold all four to that.
//!
//! [`limits`] opens the loop at the control torque for its margins; [`describing`] asks the nonlinear loop for limit
//! cycles.

#[cfg(test)]
mod agreement;
pub mod analysis;
pub mod argument;
pub mod case;
mod chebyshev;
pub mod curves;
pub mod describing;
pub mod figure;
pub mod limits;
pub mod region;
pub mod sampled;
pub mod spectrum;
#[cfg(test)]
mod testing;
mod zeros;

pub use case::{Fluid, Gains, Loop, LoopError, NormalisedGains, Plant};
