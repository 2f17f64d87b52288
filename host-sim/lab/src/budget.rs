//! How much a diagnosis may compute before it answers with what it has.
//!
//! Work is counted and not timed, so that the same files give the same answer on a slow machine, a busy one, or with any
//! number of threads. Whether it is used up is only looked at where nothing runs in parallel (`Budget::check`); what runs
//! in parallel sees the same everywhere.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Work of a diagnosis, in steps of the plant's closed form: about 60 ns each on one core of 2024, so that half a minute
/// goes into searching and refitting. Of 392 recordings of machines with concealed effects the median takes a tenth of it.
pub const WORK: u64 = 500_000_000;

/// Cells of a recording that the torque balance takes in the time of such a step.
const CELLS: u64 = 2;
/// The same of a load in its gap, whose filter goes from cell to cell.
const GAP_CELLS: f64 = 0.5;

/// What is left of the work of one diagnosis.
#[derive(Debug)]
pub struct Budget {
    spent: Arc<AtomicU64>,
    limit: u64,
    over: AtomicBool,
}

impl Default for Budget {
    fn default() -> Self {
        Self::new(WORK)
    }
}

impl Budget {
    /// One of so many steps.
    pub fn new(limit: u64) -> Self {
        Self { spent: Arc::default(), limit, over: AtomicBool::new(false) }
    }

    /// Where simulations add their steps.
    pub(crate) fn counter(&self) -> &Arc<AtomicU64> {
        &self.spent
    }

    /// Adds work, in steps.
    pub(crate) fn spend(&self, steps: u64) {
        self.spent.fetch_add(steps, Ordering::Relaxed);
    }

    /// Adds the torque balance of so many cells, behind a gap or not.
    pub(crate) fn spend_cells(&self, cells: usize, gap: bool) {
        self.spend(if gap { (cells as f64 / GAP_CELLS) as u64 } else { cells as u64 / CELLS });
    }

    /// Steps so far.
    pub fn spent(&self) -> u64 {
        self.spent.load(Ordering::Relaxed)
    }

    /// Whether the work is used up, looked at now; only where nothing of the same diagnosis runs beside.
    pub(crate) fn check(&self) -> bool {
        if self.spent() > self.limit {
            self.over.store(true, Ordering::Relaxed);
        }
        self.is_over()
    }

    /// Whether it was used up when it was last looked at.
    pub(crate) fn is_over(&self) -> bool {
        self.over.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_runs_beside_sees_no_change_until_it_is_looked_at() {
        let budget = Budget::new(10);
        budget.spend(11);
        assert!(!budget.is_over());
        assert!(budget.check() && budget.is_over());
        assert!(!Budget::default().check());
    }
}
