//! A drive that is commanded by the tool itself: parameters, and experiments that come back as recordings over the link.
//!
//! Whatever ends an experiment, the drive is told to stop before anything else is done; where it can no longer be told, it
//! stops by itself, as an enable that is not autonomous is ended by 250 ms of silence.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use er_servo::experiment::Experiment;
use er_servo::link::{Command, Status};
use er_servo::parameters::TABLE;
use er_servo::{Config, Counts, Faults, Supervisor};
use wire::connection::{Connection, LinkError, Persistence};
use wire::log::{Recording as Run, recordings};

use crate::Error;
use crate::decode::recording;
use crate::interrupt::Interrupt;
use crate::line::{Line, Stream};
use crate::read::Recording;

/// Time between two words that keep the link alive; the drive takes 250 ms of silence for a fault.
const BEAT: Duration = Duration::from_millis(20);
/// A request acts in the next tick, a stop takes up to `stop_time_s`, 5 s at most: 8 s, in ticks, as the time of a simulated
/// drive is not that of the clock.
const TAKES_EFFECT_TICKS: u32 = 16_000;
/// States, as [`Status::state`] has them.
const READY: u8 = 1;
const RUNNING: u8 = 2;
const FAULT: u8 = 3;
const STOPPING: u8 = 4;
/// Ticks at rest before an experiment begins, 0.1 s: what acted before is over.
const REST_TICKS: u32 = 200;

/// An open session in which the tool moves the axis.
pub struct Session {
    line: Line,
    connection: Connection<Box<dyn Stream>>,
    interrupt: Interrupt,
    runs: u32,
}

impl Session {
    /// Connects; refused where another client commands the drive.
    ///
    /// # Errors
    ///
    /// No connection, a drive of another release, one that another client commands or that is not ready.
    pub fn open(line: Line, persistence: Persistence, interrupt: Interrupt) -> Result<Self, Error> {
        let connection = line.connect_with(persistence)?;
        let mut session = Self { line, connection, interrupt, runs: 0 };
        if session.connection.observer {
            return Err(session.refused("another client commands the drive".to_owned()));
        }
        let status = session.status()?;
        if status.state != READY {
            return Err(session.refused(format!("the drive must be ready: {}", told(&status))));
        }
        Ok(session)
    }

    fn known<T>(&self, outcome: Result<T, LinkError>) -> Result<T, Error> {
        outcome.map_err(|error| self.line.error(error))
    }

    fn refused(&self, message: String) -> Error {
        Error::Refused { place: self.line.to_string(), message }
    }

    fn tell(&mut self, command: Command) -> Result<(), Error> {
        let outcome = self.connection.tell(command);
        self.known(outcome)
    }

    fn status(&mut self) -> Result<Status, Error> {
        let outcome = self.connection.status();
        self.known(outcome)
    }

    /// The parameters of the law.
    ///
    /// # Errors
    ///
    /// No answer, or a drive of another release.
    pub fn config(&mut self) -> Result<Config, Error> {
        let outcome = self.connection.config();
        self.known(outcome)
    }

    /// From the sampling of the position until the drive's outputs change, as its image says, s.
    pub fn sample_to_output_s(&self) -> f64 {
        self.connection.sample_to_output_s
    }

    /// Makes parameters those of the law.
    ///
    /// # Errors
    ///
    /// Values that cannot be or that do not fit the others, a drive that refuses.
    pub fn set(&mut self, values: &[(&str, f32)]) -> Result<(), Error> {
        let outcome = self.connection.set_parameters(values, false);
        self.known(outcome)
    }

    /// Makes every parameter of a configuration that of the law.
    ///
    /// # Errors
    ///
    /// As [`Self::set`].
    pub fn set_all(&mut self, config: &Config) -> Result<(), Error> {
        self.set(&all(config))
    }

    /// Gives the drive back the parameters that it had, unstable ones too if those were forced on it; of `outcome`, what it
    /// was, and of an error also that they could not be given back.
    ///
    /// # Errors
    ///
    /// That of `outcome`; no answer, or a drive that refuses.
    pub fn restored<T>(&mut self, before: &Config, outcome: Result<T, Error>) -> Result<T, Error> {
        let back = self.connection.set_parameters(&all(before), true);
        match (self.known(back), outcome) {
            (Ok(()), outcome) => outcome,
            (Err(error), Ok(_)) => Err(error),
            (Err(_), Err(error)) => {
                let lost = "the drive did not take its parameters back: before it runs, `link load` or a reset";
                Err(match error {
                    Error::Refused { place, message } => {
                        Error::Refused { place, message: format!("{message}; {lost}") }
                    }
                    Error::Connection { place, message } => {
                        Error::Connection { place, message: format!("{message}; {lost}") }
                    }
                    other => Error::connection(&self.line.to_string(), format!("{other}; {lost}")),
                })
            }
        }
    }

    /// Whether an axis that has been homed has the room to move so far up and down from where it stands, rad.
    ///
    /// # Errors
    ///
    /// [`Error::Usage`] where it has not; no answer.
    pub fn has_room(&mut self, config: &Config, up_rad: f32, down_rad: f32) -> Result<(), Error> {
        let status = self.status()?;
        let at_rad = Counts(status.position).to_rad();
        let (min_rad, max_rad) = (f64::from(config.position_min_rad), f64::from(config.position_max_rad));
        let (low, high) = (at_rad - f64::from(down_rad), at_rad + f64::from(up_rad));
        if !status.homed || min_rad <= low && high <= max_rad {
            return Ok(());
        }
        Err(Error::Usage(format!(
            "the axis stands at {:.1} degrees and would move from {:.1} to {:.1}; position_min_rad and position_max_rad \
             allow {:.1} to {:.1}: move it first, or give it less --travel-deg or --step-deg",
            at_rad.to_degrees(),
            low.to_degrees(),
            high.to_degrees(),
            min_rad.to_degrees(),
            max_rad.to_degrees()
        )))
    }

    /// An error once the user has pressed Ctrl-C.
    ///
    /// # Errors
    ///
    /// [`Error::Usage`].
    pub fn go_on(&self) -> Result<(), Error> {
        if self.interrupt.is_raised() {
            return Err(Error::Usage("interrupted; the drive is stopped".to_owned()));
        }
        Ok(())
    }

    /// The outcome of a long computation. Ctrl-C ends the wait for it; the computation ends with the process.
    ///
    /// # Errors
    ///
    /// As [`Self::go_on`].
    pub fn computed<T: Send + 'static>(&self, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Error> {
        let (send, receive) = channel();
        // A receiver that is gone has been interrupted.
        thread::spawn(move || drop(send.send(work())));
        loop {
            match receive.recv_timeout(BEAT) {
                Ok(outcome) => return Ok(outcome),
                Err(RecvTimeoutError::Timeout) => self.go_on()?,
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(Error::Usage("the computation ended without an outcome: please report it".to_owned()));
                }
            }
        }
    }

    /// Writes the parameters of the law to flash.
    ///
    /// # Errors
    ///
    /// A drive that refuses, or no answer.
    pub fn save(&mut self) -> Result<(), Error> {
        self.tell(Command::Save)
    }

    /// Ends the session.
    pub fn close(&mut self) {
        self.connection.close();
    }

    /// Enables the drive, runs an experiment, stops, and gives the recording of all of it, as `name`.
    ///
    /// # Errors
    ///
    /// A drive that refuses or trips, Ctrl-C, a recording with gaps; the drive is stopped then.
    pub fn experiment(&mut self, name: &str, experiment: Experiment, torque_bound_nm: u8) -> Result<Recording, Error> {
        self.go_on()?;
        self.runs += 1;
        let outcome = self.connection.start_recording(self.runs);
        self.known(outcome)?;
        let moved = self.moved(experiment, torque_bound_nm);
        // Whatever became of it: stopped first, and then told.
        let stopped = self.stop();
        let ended = self.tell(Command::StopRecording);
        moved.and(stopped).and(ended)?;
        let outcome = self.connection.recorded();
        let runs = recordings(&self.known(outcome)?);
        match runs.as_slice() {
            [Run { begin, frames, .. }] if runs[0].lost() == 0 && !frames.is_empty() => {
                Ok(recording(name, begin, frames))
            }
            [run] => Err(Error::connection(
                &self.line.to_string(),
                format!(
                    "{name}: {} ticks were lost on the line: check the cable, and that nothing else uses it",
                    run.lost()
                ),
            )),
            _ => Err(Error::connection(&self.line.to_string(), format!("{name}: the recording did not come whole"))),
        }
    }

    fn moved(&mut self, experiment: Experiment, torque_bound_nm: u8) -> Result<(), Error> {
        self.tell(Command::Enable { autonomous: false })?;
        self.wait("enable", |status| status.state == RUNNING)?;
        let begin = self.status()?.tick;
        self.wait_ticks(begin, REST_TICKS)?;
        self.tell(Command::Run { experiment, torque_bound_nm, autonomous: false })?;
        let ticks = (experiment.duration_s / er_servo::IMAGE_PERIOD_S) as u32;
        let begin = self.status()?.tick;
        self.wait_ticks(begin, ticks)
    }

    /// Waits in the time of the drive, which in a simulation is not that of the clock.
    fn wait_ticks(&mut self, begin: u32, ticks: u32) -> Result<(), Error> {
        loop {
            let status = self.status()?;
            if status.state != RUNNING {
                return Err(self.refused(format!("the axis stopped: {}", told(&status))));
            }
            self.go_on()?;
            if status.tick.wrapping_sub(begin) >= ticks {
                return Ok(());
            }
            let outcome = self.connection.listen_for(BEAT);
            self.known(outcome)?;
        }
    }

    fn stop(&mut self) -> Result<(), Error> {
        self.tell(Command::Disable)?;
        self.wait("disable", |status| ![RUNNING, STOPPING].contains(&status.state))
    }

    fn wait(&mut self, what: &str, shows: impl Fn(&Status) -> bool) -> Result<(), Error> {
        let begin = self.status()?.tick;
        loop {
            let status = self.status()?;
            if shows(&status) {
                return Ok(());
            }
            if status.tick.wrapping_sub(begin) > TAKES_EFFECT_TICKS || status.state == FAULT {
                return Err(self.refused(format!("{what}: {}", told(&status))));
            }
        }
    }
}

/// Every parameter that can be set: the others are built into the image.
fn all(config: &Config) -> Vec<(&'static str, f32)> {
    TABLE
        .iter()
        .filter(|parameter| !["period_s", "speed_from_converter"].contains(&parameter.name))
        .map(|parameter| (parameter.name, (parameter.get)(config)))
        .collect()
}

/// State and causes in one line.
fn told(status: &Status) -> String {
    let name = match status.state {
        0 => "it boots",
        1 => Supervisor::Ready.name(),
        2 => Supervisor::Running.name(),
        STOPPING => "it stops",
        _ => "it is in fault",
    };
    let causes = Faults::from_bits_truncate(status.faults);
    causes.explain().fold(name.to_owned(), |text, cause| text + "; " + cause)
}
