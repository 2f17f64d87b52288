//! Which hypotheses the recordings cannot tell from the best one.

mod compare;
mod information;
mod intervals;
mod parts;
mod profile;

use crate::hypothesis::{Refitted, refit};
use crate::problem::Problem;
use crate::windows::WindowFit;

pub use compare::{Comparison, LEVEL_OF_THE_SET, compare, excluded};
pub use information::{Assessed, assess};
pub(crate) use information::{OTHER_NOISE, add_spread};
pub(crate) use intervals::SMALLEST_SIZE;
pub use intervals::{Interval, TWO_SIDED_95, intervals, slopes};
pub(crate) use parts::alike_in_part;

/// Steps of a refit on a finer grid, from values that a coarser one gave.
const STEPS: usize = 4;
/// Steps of one that has an entry less, whose place others may take.
const STEPS_WITHOUT: usize = 10;

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

    /// The same on a finer grid, for values and intervals: what the coarser one of a search makes wrong is small beside what is
    /// missing, and not beside an interval. None where a pass is not finite.
    pub fn estimated(&self, finer: &Problem) -> Option<Self> {
        let coarse = &self.assessed.refitted;
        Self::new(finer, refit(finer, &coarse.hypothesis, &coarse.noise, STEPS)?).map(|step| step.widened(finer))
    }

    /// With the intervals that are reported. Where the motion is given, torque and sensor have one noise, and no split of it.
    #[must_use]
    pub fn widened(mut self, problem: &Problem) -> Self {
        if problem.motions.is_empty() {
            self.assessed = self.assessed.clone().widened_by_noise(problem).unwrap_or(self.assessed);
        }
        self.profiled(problem)
    }

    /// Without one of its entries, refitted on the same grid; its intervals are those of the search.
    pub fn without(&self, problem: &Problem, entry: usize) -> Option<Self> {
        let Refitted { hypothesis, noise, .. } = &self.assessed.refitted;
        Self::new(problem, refit(problem, &hypothesis.without(entry), noise, STEPS_WITHOUT)?)
    }

    /// Whether all of its effects may be named.
    pub fn may_be_named(&self) -> bool {
        self.assessed.refitted.hypothesis.entries.iter().all(|entry| entry.effect.nameable)
    }
}
