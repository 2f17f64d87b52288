//! Progress of work in stages, of which often only a bound is known: one line, drawn beside the work.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use progress::{End, Line, Look, Place};

/// Time between two looks: a line that moves without flickering.
const TICK: Duration = Duration::from_millis(200);
/// A stage that is shorter has no speed to be told yet.
const SPEED_KNOWN_S: f64 = 2.0;
/// Above this, seconds are told as minutes.
const MINUTES_FROM_S: f64 = 120.0;

/// A line on a terminal, wiped when this is dropped.
#[derive(Debug)]
pub(crate) struct StageLine {
    bar: ProgressBar,
    stage: Arc<Mutex<Option<Stage>>>,
    /// Wakes what draws; it ends when this is gone.
    wake: Option<Sender<()>>,
    drawing: Option<JoinHandle<()>>,
}

/// The stage that is shown.
struct Stage {
    look: Look,
    since: Instant,
    /// Steps that were done when it began.
    from: u64,
}

impl std::fmt::Debug for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Stage").field("place", &(self.look)()).finish_non_exhaustive()
    }
}

impl StageLine {
    /// The line of `what`, which begins now and shows on `target` once it has taken longer than `quiet`.
    pub(crate) fn new(what: &str, quiet: Duration, target: fn() -> ProgressDrawTarget) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        // Cut to the width of the terminal: a line that wraps is not wiped whole.
        if let Ok(style) = ProgressStyle::with_template("{spinner} {wide_msg}") {
            bar.set_style(style);
        }
        let (stage, (wake, woken)) = (Arc::new(Mutex::new(None)), channel());
        let drawn = Drawn { bar: bar.clone(), stage: Arc::clone(&stage), what: what.to_owned(), begun: Instant::now() };
        let drawing = thread::spawn(move || {
            if !ended(&woken, quiet) {
                drawn.bar.set_draw_target(target());
                drawn.until_it_ends(&woken);
            }
        });
        Self { bar, stage, wake: Some(wake), drawing: Some(drawing) }
    }
}

/// Whether the work ends within that time.
fn ended(woken: &Receiver<()>, within: Duration) -> bool {
    let until = Instant::now() + within;
    loop {
        match woken.recv_timeout(until.saturating_duration_since(Instant::now())) {
            Ok(()) => {}
            Err(why) => return why == RecvTimeoutError::Disconnected,
        }
    }
}

/// What draws the line, beside the work.
struct Drawn {
    bar: ProgressBar,
    stage: Arc<Mutex<Option<Stage>>>,
    what: String,
    begun: Instant,
}

impl Drawn {
    /// Draws again and again, at once where a stage begins.
    fn until_it_ends(&self, woken: &Receiver<()>) {
        loop {
            let text = {
                let stage = self.stage.lock().unwrap_or_else(PoisonError::into_inner);
                stage.as_ref().map_or_else(String::new, |stage| stage.text(self.begun.elapsed()))
            };
            self.bar.set_message(format!("{}{text}", self.what));
            self.bar.tick();
            if woken.recv_timeout(TICK) == Err(RecvTimeoutError::Disconnected) {
                return;
            }
        }
    }
}

impl Line for StageLine {
    fn enter(&self, look: Look) {
        let from = look().done;
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = Some(Stage { look, since: Instant::now(), from });
        // Nobody is there to be woken only where drawing has failed.
        let _ = self.wake.as_ref().map(|wake| wake.send(()));
    }
}

impl Drop for StageLine {
    fn drop(&mut self) {
        drop(self.wake.take());
        let _ = self.drawing.take().map(JoinHandle::join);
        self.bar.finish_and_clear();
    }
}

impl Stage {
    fn text(&self, gone: Duration) -> String {
        text(&(self.look)(), self.from, self.since.elapsed().as_secs_f64(), gone.as_secs())
    }
}

/// How far a stage is that began `in_stage_s` ago at `from` steps, `gone_s` after the work began.
fn text(place: &Place, from: u64, in_stage_s: f64, gone_s: u64) -> String {
    let left_of = |end: u64| {
        let done = place.done.saturating_sub(from);
        let known = done > 0 && in_stage_s >= SPEED_KNOWN_S;
        let left_s = || end.saturating_sub(place.done) as f64 * in_stage_s / done as f64;
        known.then(left_s).map(|left_s| match left_s > MINUTES_FROM_S {
            true => format!("{} min", (left_s / 60.0).ceil()),
            false => format!("{} s", left_s.ceil()),
        })
    };
    let left = match place.end {
        End::Unknown => String::new(),
        // It has taken more than it may and ends with what it has begun.
        End::AtMost { steps, to, .. } if place.done >= steps => format!(", about to come to {to}"),
        End::AtMost { steps, usually, to } => {
            let usually = left_of(usually).filter(|_| place.done < usually);
            let usually = usually.map_or_else(String::new, |left| format!(", usually {left}"));
            left_of(steps).map_or_else(String::new, |left| format!("{usually}, at most {left} to {to}"))
        }
        End::Exactly(steps) => {
            let left = left_of(steps).map_or_else(String::new, |left| format!(", about {left} left"));
            let stage = if place.stage.is_empty() { String::new() } else { format!("{}, ", place.stage) };
            return format!(": {stage}{} of {steps}, {gone_s} s gone{left}", place.done);
        }
    };
    format!(": {}, {gone_s} s gone{left}", place.stage)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(done: u64, end: End) -> Place {
        Place { stage: "search", done, end }
    }

    #[test]
    fn the_time_left_is_told_once_a_speed_is_known_and_as_a_bound_where_it_is_one() {
        let at_most = End::AtMost { steps: 400, usually: 150, to: "the verdict" };
        assert_eq!(text(&place(7, End::Unknown), 0, 9.0, 9), ": search, 9 s gone");
        assert_eq!(text(&place(3, at_most), 0, 0.5, 2), ": search, 2 s gone");
        assert_eq!(text(&place(0, at_most), 0, 5.0, 7), ": search, 7 s gone");
        // A hundred in ten seconds: of the rest of two hundred, as many were there before.
        assert_eq!(text(&place(200, at_most), 100, 10.0, 12), ": search, 12 s gone, at most 20 s to the verdict");
        let both = ": search, 12 s gone, usually 3 min, at most 7 min to the verdict";
        assert_eq!(text(&place(10, at_most), 0, 10.0, 12), both);
        assert_eq!(text(&place(401, at_most), 0, 10.0, 12), ": search, 12 s gone, about to come to the verdict");
        assert_eq!(text(&place(3, End::Exactly(9)), 0, 6.0, 8), ": search, 3 of 9, 8 s gone, about 12 s left");
        assert_eq!(text(&place(0, End::Exactly(9)), 0, 6.0, 8), ": search, 0 of 9, 8 s gone");
        let whole = Place { stage: "", ..place(3, End::Exactly(9)) };
        assert_eq!(text(&whole, 0, 6.0, 6), ": 3 of 9, 6 s gone, about 12 s left");
    }
}
