//! How far long work is, and how long its stages took, as a library says it that knows no terminal.
//!
//! The library makes a [`Progress`] and advances it, or enters the stages of a [`Course`]. Nothing shows until the program has said
//! how, once, by [`show_with`].
#![forbid(unsafe_code)]

use std::fmt::Debug;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Shows the progress of one piece of work, and takes it away when dropped.
pub trait Display: Debug + Send + Sync {
    /// `steps` more steps are done; any thread may say so.
    fn advance(&self, steps: u64);
}

/// Begins to show a piece of work by its name and its number of steps.
pub type Begin = fn(what: &str, steps: u64) -> Box<dyn Display>;

/// Shows the stages of some work, and takes them away when dropped.
pub trait Line: Debug + Send + Sync {
    /// A stage begins, which ends the one before; `look` says how far it is, whenever that is to be shown.
    fn enter(&self, look: Look);
}

/// Looks how far a stage is.
pub type Look = Box<dyn Fn() -> Place + Send + Sync>;

/// Begins to show the stages of some work by its name.
pub type BeginLine = fn(what: &str) -> Box<dyn Line>;

/// How far a stage is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Its name.
    pub stage: &'static str,
    /// Steps done, of any kind; they never fall.
    pub done: u64,
    /// Steps at which it ends.
    pub end: End,
}

/// Steps at which a stage ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Nobody knows.
    Unknown,
    /// Here or earlier, with what it is then come `to`.
    AtMost {
        /// Steps.
        steps: u64,
        /// Steps that it usually takes, no more than those.
        usually: u64,
        /// What is there then.
        to: &'static str,
    },
    /// Just here.
    Exactly(u64),
}

/// How a program shows progress.
#[derive(Debug, Clone, Copy)]
pub struct Show {
    /// Work of steps that are counted.
    pub steps: Begin,
    /// Work in stages.
    pub stages: BeginLine,
}

static SHOW: OnceLock<Show> = OnceLock::new();

/// Says how progress is shown in this process from now on; the first call decides.
pub fn show_with(show: Show) {
    SHOW.get_or_init(|| show);
}

/// Counts steps done; may be shared between threads. What is shown ends when this is dropped.
#[derive(Debug)]
pub struct Progress {
    /// None where the program shows no progress.
    shown: Option<Box<dyn Display>>,
}

impl Progress {
    /// Progress of `what`, of `steps` steps in all.
    pub fn new(what: &str, steps: u64) -> Self {
        Self { shown: SHOW.get().map(|show| (show.steps)(what, steps)) }
    }

    /// Says that `steps` more steps are done.
    pub fn advance(&self, steps: u64) {
        if let Some(shown) = &self.shown {
            shown.advance(steps);
        }
    }
}

/// Work in stages of which only one is at a time. What is shown ends when this is dropped.
#[derive(Debug)]
pub struct Course {
    /// None where nothing is shown: the program shows no progress, or this is one of many at the same time.
    shown: Option<Box<dyn Line>>,
}

impl Course {
    /// That nobody sees.
    pub fn unseen() -> Self {
        Self { shown: None }
    }

    /// Of `what`, shown as the program does.
    pub fn begin(what: &str) -> Self {
        Self { shown: SHOW.get().map(|show| (show.stages)(what)) }
    }

    /// Shown on a line of one's own.
    pub fn on(line: impl Line + 'static) -> Self {
        Self { shown: Some(Box::new(line)) }
    }

    /// A stage begins of which nothing is counted.
    pub fn enter(&self, stage: &'static str) {
        self.watch(move || Place { stage, done: 0, end: End::Unknown });
    }

    /// A stage begins that has so many steps.
    pub fn count(&self, stage: &'static str, steps: u64) -> Count {
        let count = Count::default();
        let counted = count.clone();
        self.watch(move || Place { stage, done: counted.0.load(Ordering::Relaxed), end: End::Exactly(steps) });
        count
    }

    /// A stage begins that says by itself how far it is.
    pub fn watch(&self, look: impl Fn() -> Place + Send + Sync + 'static) {
        if let Some(shown) = &self.shown {
            shown.enter(Box::new(look));
        }
    }
}

/// Counts the steps of a stage; any thread may advance it.
#[derive(Debug, Clone, Default)]
pub struct Count(Arc<AtomicU64>);

impl Count {
    /// One more step is done.
    pub fn advance(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

/// How long the stages of some work took, in the order in which they first ended.
#[derive(Debug, Clone)]
pub struct Stages {
    taken: Vec<(&'static str, Duration)>,
    since: Instant,
}

impl Stages {
    /// The first stage begins now.
    pub fn begin() -> Self {
        Self { taken: Vec::new(), since: Instant::now() }
    }

    /// The stage `name` ends and the next one begins; a name that comes again adds up.
    pub fn done(&mut self, name: &'static str) {
        let took = self.since.elapsed();
        self.since = Instant::now();
        match self.taken.iter_mut().find(|(other, _)| *other == name) {
            Some((_, sum)) => *sum += took,
            None => self.taken.push((name, took)),
        }
    }

    /// Each stage with its time.
    pub fn taken(&self) -> &[(&'static str, Duration)] {
        &self.taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_that_comes_again_adds_up() {
        let mut stages = Stages::begin();
        for name in ["prepare", "search", "prepare"] {
            stages.done(name);
        }
        let names: Vec<&str> = stages.taken().iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["prepare", "search"]);
    }
}
