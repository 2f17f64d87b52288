//! Progress of this process on standard error: one line at a time, where that is a terminal.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use indicatif::ProgressDrawTarget;
use progress::{Display, End, Line, Look, Place, Show};

use crate::progress_line::StageLine;

/// Counted work shorter than this shows nothing.
const QUIET: Duration = Duration::from_secs(1);

/// Whether a line shows.
static SHOWN: AtomicBool = AtomicBool::new(false);

/// The terminal, for one at a time: work within work that is shown has no line of its own, which would write over the other.
#[derive(Debug)]
struct Turn;

impl Turn {
    /// None where another has it, or where there is no terminal.
    fn take() -> Option<Self> {
        // The target on standard error hides itself where that is no terminal.
        let free = !ProgressDrawTarget::stderr().is_hidden() && !SHOWN.swap(true, Ordering::AcqRel);
        free.then_some(Self)
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        SHOWN.store(false, Ordering::Release);
    }
}

/// A line, and then the turn to show it: they go in this order. None where another shows.
#[derive(Debug)]
struct Shown(Option<(StageLine, Turn)>);

impl Shown {
    fn new(what: &str, quiet: Duration) -> Self {
        Self(Turn::take().map(|turn| (StageLine::new(what, quiet, ProgressDrawTarget::stderr), turn)))
    }
}

impl Line for Shown {
    fn enter(&self, look: Look) {
        if let Some((line, _)) = &self.0 {
            line.enter(look);
        }
    }
}

/// Counted work, on a line.
#[derive(Debug)]
struct Counted {
    done: Arc<AtomicU64>,
    /// Only holds the line.
    _shown: Shown,
}

impl Counted {
    fn new(what: &str, steps: u64) -> Self {
        let (done, shown) = (Arc::new(AtomicU64::new(0)), Shown::new(what, QUIET));
        let counted = Arc::clone(&done);
        shown.enter(Box::new(move || Place {
            stage: "",
            done: counted.load(Ordering::Relaxed),
            end: End::Exactly(steps),
        }));
        Self { done, _shown: shown }
    }
}

impl Display for Counted {
    fn advance(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
    }
}

/// Shows the progress of this process from now on.
pub fn show() {
    progress::show_with(Show {
        steps: |what, steps| Box::new(Counted::new(what, steps)),
        stages: |what| Box::new(Shown::new(what, Duration::ZERO)),
    });
}
