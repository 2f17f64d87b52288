//! The decision: intervals, equivalents, what is left over, and the verdict.

mod equivalents;
mod intervals;

pub use equivalents::equivalents;
pub use intervals::{Covariance, intervals};
