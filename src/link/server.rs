//! The drive's side of the command link: sessions, parameters, and what each command does, without the hardware.

use super::{Answer, Command, Counters, Malformed, PROTOCOL, Packet, Receiver, Refusal, Reply, Status};
use crate::experiment::Sequence;
use crate::storage::StorageError;
use crate::{Config, Counts, FRAME_SCHEMA, Faults, Frame, InputFlags, Params, Request, State, Supervisor, parameters};

/// What the commands act on: the image's tick, log and flash; in tests a stand-in.
pub trait Drive {
    /// Which image it is.
    fn build(&self) -> [u8; 8];
    /// Number of the next tick.
    fn tick(&self) -> u32;
    /// State of the law before it.
    fn state(&self) -> State;
    /// The last tick; none before the first.
    fn last_frame(&self) -> Option<Frame>;
    /// A packet of the session came in: the link is alive.
    fn heard(&mut self);
    /// Makes a request in the next tick.
    fn request(&mut self, request: Request);
    /// Takes the reference from the link.
    fn follow(&mut self, reference: Counts);
    /// The reference stays; an experiment ends.
    fn hold(&mut self);
    /// Runs an experiment from where the reference stands.
    fn run(&mut self, sequence: Sequence);
    /// Brings the chips up again.
    ///
    /// # Errors
    /// [`Refusal::Hardware`].
    fn reinitialise(&mut self) -> Result<(), Refusal>;
    /// Replaces the parameters of the law between two ticks.
    ///
    /// # Errors
    /// The state that forbids it.
    fn set_params(&mut self, params: Params) -> Result<(), Supervisor>;
    /// The parameters in flash.
    ///
    /// # Errors
    /// See [`StorageError`].
    fn load(&mut self) -> Result<Config, StorageError>;
    /// Stores parameters in flash, however long that takes; only asked while not running.
    ///
    /// # Errors
    /// See [`StorageError`].
    fn save(&mut self, config: &Config) -> Result<(), StorageError>;
    /// Whether a recording runs.
    fn recording(&self) -> bool;
    /// Starts a recording of the law with its parameters.
    fn start_recording(&mut self, run: u32, config: &Config);
    /// Ends the recording, if there is one.
    fn stop_recording(&mut self);
}

#[derive(Debug)]
struct Session {
    number: u32,
    /// The last packet carried out, and what was answered; none before the first.
    last: Option<Reply>,
}

/// Takes bytes, gives answers. Its memory is bounded, and so is the work for a byte, but for what a command asks of the
/// [`Drive`].
#[derive(Debug)]
pub struct Server {
    receiver: Receiver,
    session: Option<Session>,
    counters: Counters,
    /// Parameters of the law.
    config: Config,
    /// Parameters as the host has written them, not yet applied.
    staged: Config,
}

fn count(counter: &mut u32) {
    *counter = counter.wrapping_add(1);
}

impl Server {
    /// With the parameters the law was started with.
    pub fn new(config: Config) -> Self {
        let (receiver, counters) = (Receiver::default(), Counters::default());
        Self { receiver, session: None, counters, config, staged: config }
    }

    /// What became of the bytes so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Takes a byte; gives the answer that is due when it ended a packet.
    pub fn push(&mut self, byte: u8, drive: &mut impl Drive) -> Option<Reply> {
        match self.receiver.push::<Packet>(byte)? {
            Ok(packet) => self.packet(&packet, drive),
            Err(Malformed::Overlong) => {
                count(&mut self.counters.overlong);
                None
            }
            Err(Malformed::Damaged) => {
                count(&mut self.counters.damaged);
                None
            }
        }
    }

    fn packet(&mut self, packet: &Packet, drive: &mut impl Drive) -> Option<Reply> {
        let sequence = packet.sequence;
        if packet.command == Command::Hello {
            return Some(Reply { sequence, answer: self.hello(drive) });
        }
        let Some(session) = self.session.as_ref().filter(|session| session.number == packet.session) else {
            count(&mut self.counters.replayed);
            return Some(Reply { sequence, answer: Answer::Refused(Refusal::Session) });
        };
        if let Some(last) = session.last
            && sequence <= last.sequence
        {
            count(&mut self.counters.replayed);
            // Its answer may have been lost on the way; an older one's was not, or the host would not have gone on.
            return (sequence == last.sequence).then_some(last);
        }
        drive.heard();
        count(&mut self.counters.packets);
        let answer = self.carry_out(&packet.command, drive).unwrap_or_else(|refusal| {
            count(&mut self.counters.refused);
            Answer::Refused(refusal)
        });
        let reply = Reply { sequence, answer };
        if let Some(session) = &mut self.session {
            session.last = Some(reply);
        }
        Some(reply)
    }

    fn hello(&mut self, drive: &impl Drive) -> Answer {
        // The tick count makes a number that no session before it had, short of a reset; after one nothing runs.
        let tick = drive.tick();
        let session = self.session.as_ref().map_or(tick, |session| session.number.wrapping_add(1).max(tick));
        self.session = Some(Session { number: session, last: None });
        self.staged = self.config;
        Answer::Hello {
            session,
            protocol: PROTOCOL,
            frame_schema: FRAME_SCHEMA,
            parameters: parameters::TABLE.len() as u8,
            build: drive.build(),
        }
    }

    fn carry_out(&mut self, command: &Command, drive: &mut impl Drive) -> Result<Answer, Refusal> {
        match *command {
            // Handled before, as it has no session.
            Command::Hello => {}
            Command::Enable => enable(drive)?,
            Command::Disable => drive.request(Request::Disable),
            Command::ClearFault => clear(drive)?,
            Command::Reference { counts } => {
                running(drive)?;
                drive.follow(Counts(counts));
            }
            Command::Hold => {
                running(drive)?;
                drive.hold();
            }
            Command::Run(experiment) => {
                let sequence = experiment.start(self.config.period_s).map_err(|_| Refusal::Value)?;
                running(drive)?;
                drive.run(sequence);
            }
            Command::ReadParameter { index } => {
                let parameter = parameters::TABLE.get(usize::from(index)).ok_or(Refusal::Index)?;
                return Ok(Answer::Parameter { value: (parameter.get)(&self.staged) });
            }
            Command::WriteParameter { index, value } => self.write(index, value)?,
            Command::Apply => self.apply(drive)?,
            Command::Defaults => self.staged = Config::default(),
            Command::Load => self.staged = drive.load().map_err(refusal)?,
            Command::Save => {
                idle(drive)?;
                drive.save(&self.config).map_err(refusal)?;
            }
            Command::StartRecording { .. } if drive.recording() => return Err(Refusal::Recording),
            Command::StartRecording { run } => drive.start_recording(run, &self.config),
            Command::StopRecording => drive.stop_recording(),
            Command::Status => return self.status(drive).ok_or(Refusal::Booting),
        }
        Ok(Answer::Done)
    }

    fn write(&mut self, index: u8, value: f32) -> Result<(), Refusal> {
        let parameter = parameters::TABLE.get(usize::from(index)).ok_or(Refusal::Index)?;
        if !(parameter.min..=parameter.max).contains(&value) {
            return Err(Refusal::Value);
        }
        (parameter.set)(&mut self.staged, value);
        Ok(())
    }

    fn apply(&mut self, drive: &mut impl Drive) -> Result<(), Refusal> {
        idle(drive)?;
        let params = Params::new(&self.staged).map_err(|_| Refusal::Value)?;
        drive.set_params(params).map_err(|_| Refusal::Running)?;
        self.config = self.staged;
        Ok(())
    }

    fn status(&self, drive: &impl Drive) -> Option<Answer> {
        let frame = drive.last_frame()?;
        let (inputs, outputs) = (&frame.inputs, &frame.outputs);
        Some(Answer::Status(Status {
            tick: frame.seq,
            state: match outputs.supervisor {
                Supervisor::Boot { .. } => 0,
                Supervisor::Ready => 1,
                Supervisor::Running => 2,
                Supervisor::Fault { .. } => 3,
            },
            faults: outputs.supervisor.faults().bits(),
            resolver_faults: inputs.resolver.fault_byte,
            flags: inputs.flags.bits(),
            position: outputs.position.0,
            reference: inputs.reference.0,
            torque_nm: outputs.torque_nm,
            field_kv_mm: outputs.field_kv_mm,
            monitor: inputs.field_monitor.0,
            worst_cycles: frame.timing.worst_cycles,
            lost: frame.lost,
            recording: drive.recording(),
            counters: self.counters,
        }))
    }
}

fn running(drive: &impl Drive) -> Result<(), Refusal> {
    if drive.state().supervisor() == Supervisor::Running { Ok(()) } else { Err(Refusal::NotRunning) }
}

/// Neither running nor recording.
fn idle(drive: &impl Drive) -> Result<(), Refusal> {
    match drive.state().supervisor() {
        Supervisor::Running => Err(Refusal::Running),
        _ if drive.recording() => Err(Refusal::Recording),
        _ => Ok(()),
    }
}

/// Whether the pins of the last tick let the drive run; the law itself has the last word.
fn permitted(drive: &impl Drive) -> Result<(), Refusal> {
    let flags = drive.last_frame().ok_or(Refusal::Booting)?.inputs.flags;
    if !flags.contains(InputFlags::INTERLOCK_CLOSED) {
        return Err(Refusal::InterlockOpen);
    }
    if flags.contains(InputFlags::STOP_PRESSED) { Err(Refusal::StopPressed) } else { Ok(()) }
}

fn enable(drive: &mut impl Drive) -> Result<(), Refusal> {
    match drive.state().supervisor() {
        Supervisor::Boot { .. } => return Err(Refusal::Booting),
        Supervisor::Fault { .. } => return Err(Refusal::Fault),
        Supervisor::Ready | Supervisor::Running => permitted(drive)?,
    }
    drive.request(Request::Enable);
    Ok(())
}

/// Brings chips that failed up again first; the drive is in its safe state meanwhile.
fn clear(drive: &mut impl Drive) -> Result<(), Refusal> {
    let hardware = Faults::RESOLVER_CHIP | Faults::RESOLVER_BUS | Faults::OUTPUT_BUS;
    let Supervisor::Fault { faults } = drive.state().supervisor() else { return Err(Refusal::NoFault) };
    permitted(drive)?;
    if faults.intersects(hardware) {
        drive.reinitialise()?;
    }
    drive.request(Request::ClearFault);
    Ok(())
}

fn refusal(error: StorageError) -> Refusal {
    match error {
        StorageError::Flash => Refusal::Storage,
        StorageError::Empty | StorageError::Unusable => Refusal::NothingStored,
    }
}
