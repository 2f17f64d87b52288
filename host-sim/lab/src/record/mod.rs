//! One run of a drive, recorded as it comes: from the log ([`Origin`] brings the bytes), or over the command link without a
//! probe; [`Recorder`] writes the rows.

mod over_link;
#[cfg(feature = "probe")]
mod probe;
mod recorder;
#[cfg(any(feature = "probe", test))]
mod ring;
mod source;

pub use over_link::{OverLink, record_over_link};
pub use recorder::{Recorder, Summary};
pub use source::Origin;

use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use wire::log::{Error as LogError, Image};

use crate::Error;
use crate::interrupt::Interrupt;
use crate::output::Growing;

/// Between two looks at the clock and at Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// Why a recording ended.
#[derive(Debug)]
pub enum Ended {
    /// The drive said so, or was reset.
    ByDrive,
    /// Ctrl-C.
    Interrupted,
    /// The time that was asked for is over.
    Time,
    /// Nothing more came: the end of the file, or the far end hung up.
    EndOfLog,
    /// The log could not be read or decoded further.
    Broken(Error),
}

/// Which run, and for how long.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// Its number; without one, the first that begins.
    pub run: Option<u32>,
    /// For how long to listen at most.
    pub duration: Option<Duration>,
}

/// Records from `origin` into `out` until the run ends; what came until then is in the file, whatever ended it.
///
/// # Errors
///
/// An origin that cannot be opened, a log without the run, an output that cannot be written; there is no file then.
pub fn record(
    image: &Image,
    origin: &Origin,
    wanted: &Wanted,
    out: Growing,
    interrupt: &Interrupt,
) -> Result<(Summary, Ended), Error> {
    let chunks = origin.open()?;
    let unreadable = |error: LogError| Error::input(origin.to_string().as_ref(), None, "", error.to_string());
    let mut stream = image.stream();
    let mut recorder = Recorder::new(origin.to_string(), wanted.run, out);
    let start = Instant::now();
    let ended = loop {
        if interrupt.is_raised() {
            break Ended::Interrupted;
        }
        if wanted.duration.is_some_and(|duration| start.elapsed() >= duration) {
            break Ended::Time;
        }
        match chunks.recv_timeout(LOOK) {
            Ok(Ok(bytes)) => match stream.push(&bytes) {
                // Where the output fails, what was written is gone with it.
                Ok(entries) if recorder.take(&entries)? => break Ended::ByDrive,
                Ok(_) => {}
                Err(error) => break Ended::Broken(unreadable(error)),
            },
            Ok(Err(error)) => break Ended::Broken(error),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break Ended::EndOfLog,
        }
    };
    match (recorder.finish()?, ended) {
        (Some(summary), ended) => Ok((summary, ended)),
        (None, Ended::Broken(error)) => Err(error),
        (None, _) => {
            stream.finish().map_err(unreadable)?;
            Err(origin.error(match wanted.run {
                None => "no start of a recording came: start one with `servo-lab link ... start-recording`".to_owned(),
                Some(run) => format!("no start of run {run} came"),
            }))
        }
    }
}
