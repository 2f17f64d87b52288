//! Which hypotheses the recordings cannot tell from the best one.

mod compare;
mod information;
mod intervals;

use crate::windows::WindowFit;

pub use compare::{Comparison, LEVEL_OF_THE_SET, compare, excluded};
pub use information::{Assessed, assess};
pub(crate) use intervals::TWO_SIDED_95;
pub use intervals::{Interval, intervals};

/// A hypothesis at its optimum, with what its windows leave.
#[derive(Debug, Clone)]
pub struct Step {
    /// The hypothesis.
    pub assessed: Assessed,
    /// What its windows leave.
    pub windows: WindowFit,
}
