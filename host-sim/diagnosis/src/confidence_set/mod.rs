//! Which hypotheses the recordings cannot tell from the best one.

mod compare;
mod information;
mod intervals;

pub use compare::{Comparison, compare};
pub use information::{Assessed, assess};
pub(crate) use intervals::TWO_SIDED_95;
pub use intervals::{Interval, intervals};
