//! Progress of work that takes over a second, on a terminal only; and how long its stages took.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Work shorter than this shows nothing.
const QUIET: Duration = Duration::from_secs(1);

/// Counts steps done; may be shared between threads. The bar goes to standard error and is wiped when this is dropped.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    start: Instant,
}

impl Progress {
    /// Progress of `what`, of `steps` steps in all.
    pub fn new(what: &str, steps: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{msg} {bar:40} {pos}/{len}, {eta} left") {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        Self { bar, start: Instant::now() }
    }

    /// Says that `steps` more steps are done.
    pub fn advance(&self, steps: u64) {
        self.bar.inc(steps);
        // The target on standard error hides itself where that is no terminal.
        if self.bar.is_hidden() && self.start.elapsed() >= QUIET {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
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
