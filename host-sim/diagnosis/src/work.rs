//! What a diagnosis may cost: counted and not timed, so that it does the same on every machine and however many cores it has.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Substeps of three states of one diagnosis: 50 s on one core at the eight million a second that were measured on logs of 2 kHz and
/// of 370 Hz (EPYC, with all that surrounds the passes), so that any search ends within a minute.
pub const WORK: u64 = 400_000_000;

/// An account of work, in substeps of three states.
#[derive(Debug)]
pub(crate) struct Work {
    allowed: u64,
    spent: AtomicU64,
    /// Whether something was left out for it.
    cut: AtomicBool,
}

impl Clone for Work {
    fn clone(&self) -> Self {
        Self { allowed: self.allowed, spent: AtomicU64::new(self.spent()), cut: AtomicBool::new(self.was_cut()) }
    }
}

impl Work {
    /// With nothing spent.
    pub(crate) fn of(allowed: u64) -> Self {
        Self { allowed, spent: AtomicU64::new(0), cut: AtomicBool::new(false) }
    }

    pub(crate) fn spend(&self, substeps: u64) {
        self.spent.fetch_add(substeps, Ordering::Relaxed);
    }

    /// Takes over what a part has spent, and whether it was cut.
    pub(crate) fn add(&self, part: &Self) {
        self.spend(part.spent());
        if part.was_cut() {
            self.cut();
        }
    }

    pub(crate) fn spent(&self) -> u64 {
        self.spent.load(Ordering::Relaxed)
    }

    pub(crate) fn left(&self) -> u64 {
        self.allowed.saturating_sub(self.spent())
    }

    /// Notes that something was left out.
    pub(crate) fn cut(&self) {
        self.cut.store(true, Ordering::Relaxed);
    }

    /// Whether something was left out.
    pub(crate) fn was_cut(&self) -> bool {
        self.cut.load(Ordering::Relaxed)
    }
}

/// Work as it is done, over a problem and all that come of it, for whoever waits for the end; nothing is decided by it. Accounts hear
/// of a part's work only when the part ends.
#[derive(Debug, Clone, Default)]
pub struct Tally(Arc<Counts>);

#[derive(Debug, Default)]
struct Counts {
    done: AtomicU64,
    estimating: AtomicBool,
}

impl Tally {
    /// Work done so far, in substeps of three states.
    pub fn done(&self) -> u64 {
        self.0.done.load(Ordering::Relaxed)
    }

    /// Whether values are being estimated, else hypotheses are searched for.
    pub fn is_estimating(&self) -> bool {
        self.0.estimating.load(Ordering::Relaxed)
    }

    pub(crate) fn count(&self, substeps: u64) {
        self.0.done.fetch_add(substeps, Ordering::Relaxed);
    }

    pub(crate) fn estimating(&self, is: bool) {
        self.0.estimating.store(is, Ordering::Relaxed);
    }
}
