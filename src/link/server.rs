//! The drive's side of the command link: sessions, parameters, and what each command does, without the hardware.

use super::{
    Answer, Command, Counters, Drive, Malformed, PROTOCOL, Pace, Packet, ParameterSource, Receiver, Refusal, Reply,
    Status, Target,
};
use crate::storage::StorageError;
use crate::{
    Config, ConfigError, Counts, FRAME_SCHEMA, Faults, InputFlags, Params, Request, SAMPLE_TO_OUTPUT_NS, Supervisor,
    TORQUE_CEILING_NM, parameters,
};

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
    /// Of the client that commands.
    owner: Option<Session>,
    /// Of the last client that came while another commanded.
    observer: Option<Session>,
    counters: Counters,
    /// Parameters of the law.
    config: Config,
    source: ParameterSource,
    /// Parameters as the host has written them, not yet applied.
    staged: Config,
    staged_from: ParameterSource,
}

fn count(counter: &mut u32) {
    *counter = counter.wrapping_add(1);
}

/// Opens a new session in one of the two places, with a number that neither has.
fn open(place: &mut Option<Session>, number: u32) -> u32 {
    *place = Some(Session { number, last: None });
    number
}

impl Server {
    /// With the parameters the law was started with.
    pub fn new(config: Config, source: ParameterSource) -> Self {
        let (receiver, counters) = (Receiver::default(), Counters::default());
        Self { receiver, owner: None, observer: None, counters, config, source, staged: config, staged_from: source }
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
        let is_its = |session: &&Session| session.number == packet.session;
        let owner = self.owner.as_ref().filter(is_its);
        let observes = owner.is_none();
        let Some(session) = owner.or(self.observer.as_ref().filter(is_its)) else {
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
        count(&mut self.counters.packets);
        let outcome = if observes {
            self.observe(&packet.command, drive)
        } else {
            drive.heard();
            self.carry_out(&packet.command, drive)
        };
        let answer = outcome.unwrap_or_else(|refusal| {
            count(&mut self.counters.refused);
            Answer::Refused(refusal)
        });
        let reply = Reply { sequence, answer };
        let place = if observes { &mut self.observer } else { &mut self.owner };
        if let Some(session) = place {
            session.last = Some(reply);
        }
        // An ended session still answers its last packet, and commands nothing.
        if packet.command == Command::Bye && !observes {
            self.observer = self.owner.take();
        }
        Some(reply)
    }

    fn hello(&mut self, drive: &mut impl Drive) -> Answer {
        let moving = matches!(drive.state().supervisor(), Supervisor::Running | Supervisor::Stopping { .. });
        let observer = self.owner.is_some() && moving && drive.link_alive();
        let taken = [&self.owner, &self.observer].map(|session| session.as_ref().map_or(0, |session| session.number));
        let mut number = drive.random();
        // 0 is what a client without a session sends; two of the next three numbers may be taken.
        while number == 0 || taken.contains(&number) {
            number = number.wrapping_add(1);
        }
        let session = if observer { open(&mut self.observer, number) } else { open(&mut self.owner, number) };
        if !observer {
            (self.staged, self.staged_from) = (self.config, self.source);
        }
        Answer::Hello {
            session,
            observer,
            protocol: PROTOCOL,
            frame_schema: FRAME_SCHEMA,
            parameters: parameters::TABLE.len() as u8,
            build: drive.build(),
            sample_to_output_ns: SAMPLE_TO_OUTPUT_NS,
        }
    }

    /// What a client may that does not command.
    fn observe(&mut self, command: &Command, drive: &mut impl Drive) -> Result<Answer, Refusal> {
        match *command {
            Command::Status => self.status(drive).ok_or(Refusal::Booting),
            Command::ReadParameter { index } => read(&self.config, index),
            Command::Disable => {
                drive.request(Request::Disable);
                Ok(Answer::Done)
            }
            Command::Event { back } => Ok(Answer::Event(drive.event(back))),
            Command::Bye => Ok(Answer::Done),
            _ => Err(Refusal::Observer),
        }
    }

    // Over 40 lines: every command once.
    fn carry_out(&mut self, command: &Command, drive: &mut impl Drive) -> Result<Answer, Refusal> {
        match *command {
            // Handled before, as it has no session; and behind this.
            Command::Hello | Command::Bye => {}
            Command::Enable { autonomous } => enable(drive, autonomous)?,
            Command::Disable => drive.request(Request::Disable),
            Command::ClearFault => self.clear(drive)?,
            Command::SetPosition { counts } => {
                ready(drive)?;
                drive.set_position(Counts(counts));
            }
            Command::Reference { target, pace, torque_bound_nm } => refer(drive, target, &pace, torque_bound_nm)?,
            Command::Hold { autonomous } => {
                running(drive)?;
                drive.hold(autonomous);
            }
            Command::Run { experiment, torque_bound_nm, autonomous } => {
                let sequence = experiment.start(self.config.period_s).map_err(|_| Refusal::Value)?;
                bound(torque_bound_nm)?;
                running(drive)?;
                drive.run(sequence, torque_bound_nm, autonomous);
            }
            Command::ReadParameter { index } => return read(&self.staged, index),
            Command::WriteParameter { index, value } => self.write(index, value)?,
            Command::Apply { force } => self.apply(drive, force)?,
            Command::Defaults => (self.staged, self.staged_from) = (Config::default(), ParameterSource::BuiltIn),
            Command::Load => {
                self.staged = drive.load().map_err(refusal)?;
                self.staged_from = ParameterSource::stored(&self.staged);
            }
            Command::Save => {
                idle(drive)?;
                drive.save(&self.config).map_err(refusal)?;
                self.source = ParameterSource::stored(&self.config);
            }
            Command::StartRecording { .. } if drive.recording() => return Err(Refusal::Recording),
            Command::StartRecording { run, over_link } => drive.start_recording(run, over_link, &self.config),
            Command::StopRecording => drive.stop_recording(),
            Command::Status => return self.status(drive).ok_or(Refusal::Booting),
            Command::Event { back } => return Ok(Answer::Event(drive.event(back))),
        }
        Ok(Answer::Done)
    }

    fn write(&mut self, index: u8, value: f32) -> Result<(), Refusal> {
        let parameter = parameters::TABLE.get(usize::from(index)).ok_or(Refusal::Index)?;
        if !(parameter.min..=parameter.max).contains(&value) {
            return Err(Refusal::Value);
        }
        (parameter.set)(&mut self.staged, value);
        self.staged_from = ParameterSource::Link;
        Ok(())
    }

    fn apply(&mut self, drive: &mut impl Drive, force: bool) -> Result<(), Refusal> {
        idle(drive)?;
        let sound = Params::for_image(&self.staged, false);
        let forced = force && matches!(sound, Err(ConfigError::Unstable(_)));
        let params = if forced { Params::for_image(&self.staged, true) } else { sound };
        let params = params.map_err(|error| match error {
            ConfigError::Unstable(_) => Refusal::Unstable,
            ConfigError::BuiltIn { .. } => Refusal::BuiltIn,
            _ => Refusal::Value,
        })?;
        drive.set_params(params, forced).map_err(|_| Refusal::Running)?;
        self.config = self.staged;
        let is_stored = self.staged_from == ParameterSource::StoredForced;
        self.source = if forced && !is_stored { ParameterSource::Forced } else { self.staged_from };
        Ok(())
    }

    /// Brings chips that failed up again first; the drive is in its safe state meanwhile.
    fn clear(&self, drive: &mut impl Drive) -> Result<(), Refusal> {
        let hardware = Faults::RESOLVER_CHIP | Faults::RESOLVER_BUS | Faults::OUTPUT_BUS;
        let Supervisor::Fault { faults } = drive.state().supervisor() else { return Err(Refusal::NoFault) };
        if self.source == ParameterSource::Damaged {
            return Err(Refusal::ParametersDamaged);
        }
        permitted(drive)?;
        if faults.intersects(hardware) {
            drive.reinitialise()?;
        }
        drive.make_room_for_events();
        drive.request(Request::ClearFault);
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
                Supervisor::Stopping { .. } => 4,
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
            homed: drive.state().homed(),
            parameters: self.source,
            counters: self.counters,
        }))
    }
}

fn read(config: &Config, index: u8) -> Result<Answer, Refusal> {
    let parameter = parameters::TABLE.get(usize::from(index)).ok_or(Refusal::Index)?;
    Ok(Answer::Parameter { value: (parameter.get)(config) })
}

fn refer(drive: &mut impl Drive, target: Target, pace: &Pace, torque_bound_nm: u8) -> Result<(), Refusal> {
    bound(torque_bound_nm)?;
    if !pace.is_valid() {
        return Err(Refusal::Value);
    }
    running(drive)?;
    let homed = drive.state().homed();
    let counts = match target {
        Target::Absolute(_) if !homed => return Err(Refusal::NotHomed),
        Target::Absolute(counts) => Counts(counts),
        Target::Relative(counts) => Counts(drive.target().0.saturating_add(counts)),
    };
    if homed && !drive.motion().allow(counts) {
        return Err(Refusal::BeyondLimits);
    }
    drive.follow(counts, pace, torque_bound_nm);
    Ok(())
}

fn bound(torque_bound_nm: u8) -> Result<(), Refusal> {
    if f32::from(torque_bound_nm) <= TORQUE_CEILING_NM { Ok(()) } else { Err(Refusal::Value) }
}

fn ready(drive: &impl Drive) -> Result<(), Refusal> {
    if drive.state().supervisor() == Supervisor::Ready { Ok(()) } else { Err(Refusal::NotReady) }
}

fn running(drive: &impl Drive) -> Result<(), Refusal> {
    if drive.state().supervisor() == Supervisor::Running { Ok(()) } else { Err(Refusal::NotRunning) }
}

/// Neither running nor recording.
fn idle(drive: &impl Drive) -> Result<(), Refusal> {
    match drive.state().supervisor() {
        Supervisor::Running | Supervisor::Stopping { .. } => Err(Refusal::Running),
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

fn enable(drive: &mut impl Drive, autonomous: bool) -> Result<(), Refusal> {
    match drive.state().supervisor() {
        Supervisor::Boot { .. } => return Err(Refusal::Booting),
        Supervisor::Fault { .. } => return Err(Refusal::Fault),
        Supervisor::Stopping { .. } => return Err(Refusal::NotReady),
        Supervisor::Ready | Supervisor::Running => permitted(drive)?,
    }
    let flags = drive.last_frame().ok_or(Refusal::Booting)?.inputs.flags;
    if !flags.contains(InputFlags::AMPLIFIER_READY) {
        return Err(Refusal::AmplifierNotReady);
    }
    drive.enable(autonomous);
    Ok(())
}

fn refusal(error: StorageError) -> Refusal {
    match error {
        StorageError::Flash => Refusal::Storage,
        StorageError::Empty | StorageError::Unusable => Refusal::NothingStored,
    }
}
