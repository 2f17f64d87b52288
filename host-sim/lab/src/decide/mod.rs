//! The decision: intervals, equivalents, what is left over, and the verdict.

mod checks;
mod controller;
mod diagnose;
mod equivalents;
mod intervals;
#[cfg(test)]
pub(crate) mod testing;
pub mod twin;

pub use diagnose::{Diagnosis, Request, diagnose};
pub use equivalents::equivalents;
pub use intervals::{Covariance, intervals};
