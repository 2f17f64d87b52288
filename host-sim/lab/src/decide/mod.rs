//! The decision: intervals, equivalents, what is left over, and the verdict.

mod controller;
mod diagnose;
mod equivalents;
mod intervals;
mod prepare;
mod refined;

pub use diagnose::{Diagnosis, Request, diagnose};
pub use equivalents::equivalents;
pub use intervals::{Covariance, intervals};
pub use refined::Refined;
