//! Which models are left of a ranking.

use diagnosis::confidence_set::intervals;
use diagnosis::ranking::Ranked;

use super::contenders::special_cases;

/// Where a model stands among all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Standing {
    /// The recordings do not exclude it. A model is what any special case of it is, so it stands where one of those does.
    pub(super) in_set: bool,
    /// It is left: in the set, and none of its delays may be zero as in a special case that is in the set too.
    pub(super) needed: bool,
}

impl Standing {
    pub(super) fn of(all: &[Ranked], one: &Ranked) -> Self {
        let simpler = all.iter().any(|other| other.in_set && special_cases(one.name).contains(&other.name));
        let in_set = one.in_set || simpler;
        Self { in_set, needed: in_set && (!simpler || away_from_zero(one)) }
    }
}

/// Whether the 95 % interval of every delay lies above zero.
fn away_from_zero(one: &Ranked) -> bool {
    let assessed = &one.step.assessed;
    let entries = 0..assessed.refitted.hypothesis.entries.len();
    entries.flat_map(|at| intervals(assessed, at)).all(|interval| interval.low > 0.0)
}
