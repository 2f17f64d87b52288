//! A recording over the command link: the drive sends every tick beside its answers.

use std::time::Instant;

use er_servo::link::Command;
use wire::connection::Connection;

use super::{Ended, LOOK, Recorder, Summary, Wanted};
use crate::Error;
use crate::interrupt::Interrupt;
use crate::line::{Line, Stream};
use crate::output::Growing;

/// A recording that comes in over a connection which has other things to say too.
pub struct OverLink {
    line: Line,
    recorder: Recorder,
}

impl OverLink {
    /// Starts it.
    ///
    /// # Errors
    ///
    /// A drive that refuses, or no answer.
    pub fn start(
        line: &Line,
        connection: &mut Connection<Box<dyn Stream>>,
        run: u32,
        out: Growing,
    ) -> Result<Self, Error> {
        connection.start_recording(run).map_err(|error| line.error(error))?;
        Ok(Self { line: line.clone(), recorder: Recorder::new(line.to_string(), Some(run), out) })
    }

    /// Writes what has come in; whether the run has ended with it.
    ///
    /// # Errors
    ///
    /// A recording of another release, or an output that cannot be written.
    pub fn take(&mut self, connection: &mut Connection<Box<dyn Stream>>) -> Result<bool, Error> {
        let entries = connection.recorded().map_err(|error| self.line.error(error))?;
        self.recorder.take(&entries)
    }

    /// Ends it at the drive, and writes what was still on its way, which comes before the answer.
    ///
    /// # Errors
    ///
    /// A refusal, no answer, a recording of which not even the begin came, or an output that cannot be written.
    pub fn end(mut self, connection: &mut Connection<Box<dyn Stream>>) -> Result<Summary, Error> {
        connection.tell(Command::StopRecording).map_err(|error| self.line.error(error))?;
        self.take(connection)?;
        self.keep()
    }

    /// Gives the file its name with what came.
    fn keep(self) -> Result<Summary, Error> {
        let none = || Error::connection(&self.line.to_string(), "the begin of the recording did not come: try again");
        self.recorder.finish()?.ok_or_else(none)
    }
}

/// Records over the link until the time is over or Ctrl-C, without moving anything. What came until then is in the file, whatever
/// ended it.
///
/// # Errors
///
/// No connection, a drive that refuses, a recording of which not even the begin came, an output that cannot be written.
pub fn record_over_link(
    line: &Line,
    wanted: &Wanted,
    out: Growing,
    interrupt: &Interrupt,
) -> Result<(Summary, Ended), Error> {
    let mut connection = line.connect()?;
    let mut recording = OverLink::start(line, &mut connection, wanted.run.unwrap_or(1), out)?;
    let start = Instant::now();
    let mut look = || -> Result<Option<Ended>, Error> {
        if interrupt.is_raised() {
            return Ok(Some(Ended::Interrupted));
        }
        if wanted.duration.is_some_and(|duration| start.elapsed() >= duration) {
            return Ok(Some(Ended::Time));
        }
        connection.listen_for(LOOK).map_err(|error| line.error(error))?;
        // A drive that was reset records no longer.
        let status = connection.status().map_err(|error| line.error(error))?;
        let has_ended = recording.take(&mut connection)? || !status.recording;
        Ok(has_ended.then_some(Ended::ByDrive))
    };
    let ended = loop {
        match look() {
            Ok(None) => {}
            Ok(Some(ended)) => break ended,
            Err(error @ Error::Output { .. }) => return Err(error),
            Err(error) => break Ended::Broken(error),
        }
    };
    let summary = match ended {
        Ended::Broken(_) | Ended::ByDrive => recording.keep(),
        _ => recording.end(&mut connection),
    };
    connection.close();
    match (summary, ended) {
        (Err(_), Ended::Broken(error)) => Err(error),
        (summary, ended) => Ok((summary?, ended)),
    }
}
