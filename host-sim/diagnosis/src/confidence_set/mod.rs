//! Which hypotheses the recordings cannot tell from the best one.

mod compare;
mod information;
mod intervals;

pub use compare::{Comparison, compare};
pub use information::{Assessed, assess};
pub use intervals::{Interval, intervals};
