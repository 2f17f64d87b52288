//! Which hypotheses the recordings cannot tell from the best one.

mod compare;
mod information;
mod intervals;

use crate::hypothesis::Refitted;
use crate::problem::Problem;
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

impl Step {
    /// Of a hypothesis at its optimum, on all recordings; none where a pass is not finite.
    pub fn new(problem: &Problem, refitted: Refitted) -> Option<Self> {
        let refitted = refitted.over_all(problem)?;
        let windows = WindowFit::new(problem, &refitted)?;
        Some(Self { assessed: assess(problem, refitted)?, windows })
    }

    /// Whether all of its effects may be named.
    pub fn may_be_named(&self) -> bool {
        self.assessed.refitted.hypothesis.entries.iter().all(|entry| entry.effect.nameable)
    }
}
