//! Turns what a drive tells of one run into rows, piece by piece.

use er_servo::Frame;
use wire::log::{Begin, Entry, Ticks};

use crate::Error;
use crate::decode::recording;
use crate::output::Growing;

/// What was recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// How the run began.
    pub begin: Begin,
    /// Ticks that came and that are missing.
    pub ticks: Ticks,
    /// Messages that were damaged or of another time, occurrences.
    pub damaged: u64,
}

impl std::fmt::Display for Summary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { begin, ticks, damaged } = self;
        let (run, taken, lost, gaps) = (begin.run, ticks.taken, ticks.lost, ticks.gaps);
        write!(f, "run {run}: {taken} ticks, {lost} lost in {gaps} gaps, {damaged} damaged messages")
    }
}

/// Writes one run as it comes.
pub struct Recorder {
    name: String,
    run: Option<u32>,
    summary: Option<Summary>,
    out: Growing,
}

impl Recorder {
    /// Waits for the run of that number, or for any; `name` is where it comes from.
    pub fn new(name: String, run: Option<u32>, out: Growing) -> Self {
        Self { name, run, summary: None, out }
    }

    /// Takes entries; whether the run has ended with them. Events go to standard error.
    ///
    /// # Errors
    ///
    /// An output that cannot be written.
    pub fn take(&mut self, entries: &[Entry]) -> Result<bool, Error> {
        let mut frames = Vec::new();
        let has_ended = entries.iter().any(|entry| self.entry(entry, &mut frames));
        if let Some(summary) = self.summary.as_ref().filter(|_| !frames.is_empty()) {
            self.out.append(&recording(&self.name, &summary.begin, &frames))?;
        }
        Ok(has_ended)
    }

    fn entry(&mut self, entry: &Entry, frames: &mut Vec<Frame>) -> bool {
        if let Entry::Event(text) = entry {
            eprintln!("{text}");
        }
        let Some(summary) = &mut self.summary else {
            if let Entry::Begin(begin) = entry
                && self.run.is_none_or(|run| run == begin.run)
            {
                let ticks = Ticks::from(begin.tick);
                self.summary = Some(Summary { begin: (**begin).clone(), ticks, damaged: 0 });
            }
            return false;
        };
        match entry {
            Entry::Frame(frame) if summary.ticks.take(frame.seq) => frames.push(**frame),
            Entry::Frame(_) | Entry::Damaged => summary.damaged += 1,
            _ => {}
        }
        entry.ends_recording()
    }

    /// Ends the recording; none where the run did not begin, and no file then.
    ///
    /// # Errors
    ///
    /// An output that cannot be written.
    pub fn finish(self) -> Result<Option<Summary>, Error> {
        let Self { name, summary, mut out, .. } = self;
        let Some(summary) = summary else { return Ok(None) };
        if summary.ticks.taken == 0 {
            out.append(&recording(&name, &summary.begin, &[]))?;
        }
        out.finish()?;
        Ok(Some(summary))
    }
}
