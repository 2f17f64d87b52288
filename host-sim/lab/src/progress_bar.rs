//! Progress of counted work that takes over a second, on a terminal only.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use progress::Show;

use crate::progress_line::StageLine;

/// Work shorter than this shows nothing.
const QUIET: Duration = Duration::from_secs(1);

/// A bar on standard error, wiped when this is dropped.
#[derive(Debug)]
struct Bar {
    bar: ProgressBar,
    start: Instant,
}

/// Shows the progress of this process from now on as bars and lines on standard error, where that is a terminal.
pub fn show() {
    progress::show_with(Show {
        steps: |what, steps| Box::new(Bar::new(what, steps)),
        stages: |what| Box::new(StageLine::new(what, ProgressDrawTarget::stderr())),
    });
}

impl Bar {
    fn new(what: &str, steps: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{msg} {bar:40} {percent} %, {elapsed} gone, {eta} left") {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        Self { bar, start: Instant::now() }
    }
}

impl progress::Display for Bar {
    fn advance(&self, steps: u64) {
        self.bar.inc(steps);
        // The target on standard error hides itself where that is no terminal.
        if self.bar.is_hidden() && self.start.elapsed() >= QUIET {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
