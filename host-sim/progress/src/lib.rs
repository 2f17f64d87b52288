//! How far long work is, and how long its stages took, as a library says it that knows no terminal.
//!
//! The library makes a [`Progress`] and advances it. Nothing shows until the program has said how, once, by [`show_with`].
#![forbid(unsafe_code)]

use std::fmt::Debug;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Shows the progress of one piece of work, and takes it away when dropped.
pub trait Display: Debug + Send + Sync {
    /// `steps` more steps are done; any thread may say so.
    fn advance(&self, steps: u64);
}

/// Begins to show a piece of work by its name and its number of steps.
pub type Begin = fn(what: &str, steps: u64) -> Box<dyn Display>;

static BEGIN: OnceLock<Begin> = OnceLock::new();

/// Says how progress is shown in this process from now on; the first call decides.
pub fn show_with(begin: Begin) {
    BEGIN.get_or_init(|| begin);
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
        Self { shown: BEGIN.get().map(|begin| begin(what, steps)) }
    }

    /// Says that `steps` more steps are done.
    pub fn advance(&self, steps: u64) {
        if let Some(shown) = &self.shown {
            shown.advance(steps);
        }
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
