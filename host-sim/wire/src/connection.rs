//! A conversation with a drive: one command at a time, sent again until it is answered.
//!
//! A packet sent again carries the sequence number it had: the drive answers it again and does not carry it out again.

use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use er_servo::events::Event;
use er_servo::link::{Answer, Command, PROTOCOL, Refusal, Status};
use er_servo::parameters::{Parameter, TABLE};
use er_servo::{Config, Params};

use crate::client::Client;
use crate::log::{Build, Entry};
use crate::parameter::{self, ParameterError};

/// A save erases flash, which takes up to 1.6 s, as may a clear, for a full event log; nothing is answered meanwhile.
const ERASE_PATIENCE: Duration = Duration::from_secs(3);

/// Why a command was not carried out, or nobody knows whether it was.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The port or the network failed.
    #[error("the connection failed: {0}")]
    Stream(#[from] std::io::Error),
    /// The far end hung up.
    #[error("the far end closed the connection")]
    Closed,
    /// No answer, however often it was asked.
    #[error("{command:?}: no answer to {attempts} attempts{}", heard(*bytes, *damaged))]
    Silent {
        /// What was asked.
        command: Command,
        /// How often.
        attempts: u32,
        /// Bytes that came in meanwhile.
        bytes: usize,
        /// Answers among them that were damaged.
        damaged: u32,
    },
    /// The drive speaks another version.
    #[error("the drive speaks version {drive} of the link, this tool {PROTOCOL}: use the tool of the flashed release")]
    Protocol {
        /// Version of the drive.
        drive: u16,
    },
    /// The drive has other parameters.
    #[error("the drive has {drive} parameters, this tool {}: use the tool of the flashed release", TABLE.len())]
    Parameters {
        /// Number of the drive's.
        drive: u8,
    },
    /// The drive said no.
    #[error("the drive refused: {0}")]
    Refused(Refusal),
    /// What is recorded over the link is of another release.
    #[error(transparent)]
    Recording(#[from] crate::log::Error),
    /// A parameter that the drive would not take, found before it was sent.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The answer is none to what was asked.
    #[error("{command:?} was answered by {answer:?}")]
    Unexpected {
        /// What was asked.
        command: Command,
        /// What came.
        answer: Box<Answer>,
    },
}

fn heard(bytes: usize, damaged: u32) -> String {
    match (bytes, damaged) {
        (0, _) => ", not a byte: check that the drive is powered and that this is its port".to_owned(),
        (bytes, 0) => format!("; {bytes} bytes came, but no packet: check the baud rate and that this is its port"),
        (_, damaged) => format!("; {damaged} answers were damaged: check the cable"),
    }
}

/// How long and how often to ask.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Persistence {
    /// Wait for an answer.
    pub patience: Duration,
    /// Times a command is sent before it is given up; at least once.
    pub attempts: u32,
}

impl Default for Persistence {
    /// An answer takes a millisecond, and up to 16 more in a USB adapter. Two attempts fit into the 250 ms after which the
    /// drive takes the link for dead ([`er_servo::link::SILENCE_S`]).
    fn default() -> Self {
        Self { patience: Duration::from_millis(100), attempts: 6 }
    }
}

/// An open session over a stream of bytes, whose reads must give up after some 10 ms without a byte
/// ([`ErrorKind::TimedOut`] or [`ErrorKind::WouldBlock`]).
#[derive(Debug)]
pub struct Connection<S> {
    stream: S,
    client: Client,
    persistence: Persistence,
    bytes: usize,
    /// Which image the drive runs.
    pub build: Build,
    /// Another client commands the drive: it may be read and stopped.
    pub observer: bool,
    /// From the sampling of the position until torque and field change at the drive's outputs, s.
    pub sample_to_output_s: f64,
    parameters: u8,
}

impl<S: Read + Write> Connection<S> {
    /// Says hello.
    ///
    /// # Errors
    ///
    /// No drive there, or one of another version.
    pub fn open(stream: S, persistence: Persistence) -> Result<Self, LinkError> {
        // Answers to a client before this one may still be on their way. Half the range is left, so as not to wrap.
        let clock = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let client = Client::after(clock.as_millis() as u32 & u32::MAX >> 1);
        let build = Build::default();
        let (observer, parameters, sample_to_output_s) = (false, 0, 0.0);
        let mut connection =
            Self { stream, client, persistence, bytes: 0, build, observer, sample_to_output_s, parameters };
        let (answer, attempts) = connection.converse(Command::Hello)?;
        let Answer::Hello { protocol, parameters, build, observer, sample_to_output_ns, .. } = answer else {
            return Err(LinkError::Unexpected { command: Command::Hello, answer: Box::new(answer) });
        };
        if protocol != PROTOCOL {
            return Err(LinkError::Protocol { drive: protocol });
        }
        (connection.build, connection.parameters, connection.observer) = (build, parameters, observer);
        connection.sample_to_output_s = f64::from(sample_to_output_ns) / 1e9;
        if attempts > 1 {
            // Each hello opens a session of its own: the last one to be answered is the one that holds.
            connection.listen(None, persistence.patience)?;
        }
        Ok(connection)
    }

    /// Ends the session, so that another client need not wait until this one is silent. Nobody minds a drive that no longer
    /// answers.
    pub fn close(&mut self) {
        let _ = self.tell(Command::Bye);
    }

    /// Asks, and waits for the answer.
    ///
    /// # Errors
    ///
    /// A refusal, or no answer.
    pub fn ask(&mut self, command: Command) -> Result<Answer, LinkError> {
        match self.converse(command)?.0 {
            Answer::Refused(refusal) => Err(LinkError::Refused(refusal)),
            answer => Ok(answer),
        }
    }

    /// Has a command carried out that has no other answer than that it was.
    ///
    /// # Errors
    ///
    /// A refusal, or no answer.
    pub fn tell(&mut self, command: Command) -> Result<(), LinkError> {
        match self.ask(command)? {
            Answer::Done => Ok(()),
            answer => Err(LinkError::Unexpected { command, answer: Box::new(answer) }),
        }
    }

    /// How the drive is.
    ///
    /// # Errors
    ///
    /// A refusal, or no answer.
    pub fn status(&mut self) -> Result<Status, LinkError> {
        match self.ask(Command::Status)? {
            Answer::Status(status) => Ok(status),
            answer => Err(LinkError::Unexpected { command: Command::Status, answer: Box::new(answer) }),
        }
    }

    /// Listens for a time, to what is recorded over the link.
    ///
    /// # Errors
    ///
    /// A connection that broke off.
    pub fn listen_for(&mut self, time: Duration) -> Result<(), LinkError> {
        self.listen(None, time).map(drop)
    }

    /// What of recordings has come in since the last time, while waiting for answers too.
    ///
    /// # Errors
    ///
    /// A recording of another release.
    pub fn recorded(&mut self) -> Result<Vec<Entry>, LinkError> {
        Ok(self.client.recorded()?)
    }

    /// Starts a recording over the link.
    ///
    /// # Errors
    ///
    /// A refusal, or no answer.
    pub fn start_recording(&mut self, run: u32) -> Result<(), LinkError> {
        self.client.keep_recorded();
        self.tell(Command::StartRecording { run, over_link: true })
    }

    /// The newest fault of the event log but `back`; none where there are fewer.
    ///
    /// # Errors
    ///
    /// A refusal, or no answer.
    pub fn event(&mut self, back: u8) -> Result<Option<Event>, LinkError> {
        let command = Command::Event { back };
        match self.ask(command)? {
            Answer::Event(event) => Ok(event),
            answer => Err(LinkError::Unexpected { command, answer: Box::new(answer) }),
        }
    }

    /// The staged value of a parameter, by its name; at the start of a session that of the law.
    ///
    /// # Errors
    ///
    /// An unknown name, a refusal, no answer, or a drive with other parameters.
    pub fn parameter(&mut self, name: &str) -> Result<f32, LinkError> {
        let (index, _) = parameter::find(name)?;
        self.same_table()?;
        self.read(index)
    }

    /// Every staged parameter; at the start of a session those of the law.
    ///
    /// # Errors
    ///
    /// A refusal, no answer, or a drive with other parameters.
    pub fn config(&mut self) -> Result<Config, LinkError> {
        self.same_table()?;
        let mut config = Config::default();
        for (index, parameter) in (0..).zip(TABLE) {
            (parameter.set)(&mut config, self.read(index)?);
        }
        Ok(config)
    }

    /// Writes parameters by name and makes them those of the law, all or none: names, ranges and whether they fit the others
    /// are checked before the first is sent. With `force` even if the loop would be unstable.
    ///
    /// # Errors
    ///
    /// A parameter that cannot be, a refusal, no answer, or a drive with other parameters.
    pub fn set_parameters(&mut self, values: &[(&str, f32)], force: bool) -> Result<(), LinkError> {
        let found = values.iter().map(|(name, value)| {
            let (index, parameter) = parameter::find(name)?;
            parameter::check(parameter, *value)?;
            Ok((index, parameter, *value))
        });
        let found: Vec<(u8, &Parameter, f32)> = found.collect::<Result<_, ParameterError>>()?;
        let mut config = self.config()?;
        for (_, parameter, value) in &found {
            (parameter.set)(&mut config, *value);
        }
        Params::for_image(&config, force).map_err(ParameterError::Combination)?;
        for (index, _, value) in found {
            self.tell(Command::WriteParameter { index, value })?;
        }
        self.tell(Command::Apply { force })
    }

    fn read(&mut self, index: u8) -> Result<f32, LinkError> {
        let command = Command::ReadParameter { index };
        match self.ask(command)? {
            Answer::Parameter { value } => Ok(value),
            answer => Err(LinkError::Unexpected { command, answer: Box::new(answer) }),
        }
    }

    fn same_table(&self) -> Result<(), LinkError> {
        let drive = self.parameters;
        if usize::from(drive) == TABLE.len() { Ok(()) } else { Err(LinkError::Parameters { drive }) }
    }

    /// The answer, and how often it was asked for.
    fn converse(&mut self, command: Command) -> Result<(Answer, u32), LinkError> {
        let (sequence, packet) = self.client.send(command);
        let patience = match command {
            Command::Save | Command::ClearFault => self.persistence.patience.max(ERASE_PATIENCE),
            _ => self.persistence.patience,
        };
        let attempts = self.persistence.attempts.max(1);
        (self.bytes, self.client.damaged) = (0, 0);
        for attempt in 1..=attempts {
            self.stream.write_all(&packet)?;
            self.stream.flush()?;
            if let Some(answer) = self.listen(Some((command, sequence)), patience)? {
                return Ok((answer, attempt));
            }
        }
        Err(LinkError::Silent { command, attempts, bytes: self.bytes, damaged: self.client.damaged })
    }

    /// Listens until the answer to a command has come, or time is up.
    fn listen(&mut self, asked: Option<(Command, u32)>, patience: Duration) -> Result<Option<Answer>, LinkError> {
        let deadline = Instant::now() + patience;
        let mut buffer = [0; 256];
        while Instant::now() < deadline {
            let count = match self.stream.read(&mut buffer) {
                Ok(0) => return Err(LinkError::Closed),
                Ok(count) => count,
                Err(error) => match error.kind() {
                    ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted => continue,
                    _ => return Err(error.into()),
                },
            };
            self.bytes += count;
            let mut found = None;
            for byte in buffer.iter().take(count) {
                let Some(reply) = self.client.receive(*byte) else { continue };
                let is_hello = matches!(reply.answer, Answer::Hello { .. });
                if asked.is_some_and(|(command, sequence)| {
                    sequence == reply.sequence && is_hello == (command == Command::Hello)
                }) {
                    found = Some(reply.answer);
                }
            }
            if found.is_some() {
                return Ok(found);
            }
        }
        Ok(None)
    }
}
