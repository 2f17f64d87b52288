//! The decision: intervals, equivalents, what is left over, and the verdict.

mod checks;
mod closest;
mod coincidence;
mod confirmed;
mod controller;
mod detour;
mod diagnose;
mod equivalents;
mod fitted;
mod gap;
mod glitches;
mod intervals;
mod named;
mod prepare;
mod refined;
mod simulated;
mod stretches;
#[cfg(test)]
pub(crate) mod testing;
pub mod twin;
mod verdict;

pub(crate) use controller::mismatch;
pub use diagnose::{Diagnosis, Request, diagnose, diagnose_within};
pub(crate) use fitted::explained;
pub use intervals::{Covariance, intervals};
pub use refined::Refined;
pub(crate) use stretches::stretches;
