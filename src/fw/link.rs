//! The command link in thread mode. Bytes come in by DMA into a ring, so that none of them costs the tick anything.

use embedded_hal_nb::serial::Write;
use er_servo::experiment::Sequence;
use er_servo::link::{
    Answer, Command, Counters, Malformed, PACKET_BYTES, PROTOCOL, Packet, Receiver, Refusal, Reply, Status,
};
use er_servo::storage::StorageError;
use er_servo::{Config, Counts, FRAME_SCHEMA, Faults, Frame, Params, Request, Supervisor, parameters};
use heapless::Deque;
use heapless::spsc::Producer;
use stm32f4xx_hal::pac::USART2;
use stm32f4xx_hal::serial::Tx;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

use super::board::{QUEUE_OFFSETS, Ring};
use super::log::{self, Log};
use super::storage::Storage;
use super::tick::{self, Offset};

/// Bytes of answers that wait for the line; more are dropped, the host asks again.
const OUT_BYTES: usize = 4 * PACKET_BYTES;

/// The link and what it acts on.
pub struct Link {
    ring: Ring,
    tx: Tx<USART2>,
    out: Deque<u8, OUT_BYTES>,
    receiver: Receiver,
    session: Option<Session>,
    counters: Counters,
    storage: Storage,
    /// Parameters of the law.
    config: Config,
    /// Parameters as the host has written them, not yet applied.
    staged: Config,
    last: Option<Frame>,
    /// The experiment that runs, and where its offsets go.
    sequence: Option<Sequence>,
    offsets: Producer<'static, Offset, QUEUE_OFFSETS>,
}

struct Session {
    number: u32,
    last_sequence: u32,
}

impl Link {
    /// With the parameters the law was started with.
    pub fn new(
        ring: Ring,
        tx: Tx<USART2>,
        storage: Storage,
        config: Config,
        offsets: Producer<'static, Offset, QUEUE_OFFSETS>,
    ) -> Self {
        Self {
            ring,
            tx,
            out: Deque::new(),
            receiver: Receiver::default(),
            session: None,
            counters: Counters::default(),
            storage,
            config,
            staged: config,
            last: None,
            sequence: None,
            offsets,
        }
    }

    /// Takes note of a tick, for the status.
    pub fn frame(&mut self, frame: &Frame) {
        self.last = Some(*frame);
    }

    /// Handles what came in since the last time, and sends on; never waits.
    pub fn poll(&mut self, log: &mut Log, watchdog: &mut IndependentWatchdog) {
        while let Some(byte) = self.ring.next() {
            match self.receiver.push::<Packet>(byte) {
                None => {}
                Some(Ok(packet)) => self.packet(&packet, log, watchdog),
                Some(Err(Malformed::Overlong)) => self.counters.overlong = self.counters.overlong.wrapping_add(1),
                Some(Err(Malformed::Damaged)) => self.counters.damaged = self.counters.damaged.wrapping_add(1),
            }
        }
        self.compute_ahead();
        while let Some(byte) = self.out.front() {
            match self.tx.write(*byte) {
                Err(nb::Error::WouldBlock) => break,
                // A byte the line refused is gone; the host's check finds it.
                _ => self.out.pop_front(),
            };
        }
    }

    /// Keeps the queue of offsets full.
    fn compute_ahead(&mut self) {
        while self.offsets.ready() {
            let Some(sequence) = &mut self.sequence else { return };
            let offset = sequence.next().map_or(Offset::End, Offset::Counts);
            if matches!(offset, Offset::End) {
                self.sequence = None;
            }
            let _ = self.offsets.enqueue(offset);
        }
    }

    /// Whether an answer is on its way.
    pub fn sending(&self) -> bool {
        !self.out.is_empty()
    }

    fn packet(&mut self, packet: &Packet, log: &mut Log, watchdog: &mut IndependentWatchdog) {
        if packet.command == Command::Hello {
            let answer = self.hello();
            self.answer(packet.sequence, answer);
            return;
        }
        let Some(session) = self.session.as_mut().filter(|session| session.number == packet.session) else {
            self.counters.replayed = self.counters.replayed.wrapping_add(1);
            self.answer(packet.sequence, Answer::Refused(Refusal::Session));
            return;
        };
        if packet.sequence <= session.last_sequence {
            self.counters.replayed = self.counters.replayed.wrapping_add(1);
            return;
        }
        session.last_sequence = packet.sequence;
        tick::with(tick::Tick::heard);
        self.counters.packets = self.counters.packets.wrapping_add(1);
        let answer = match self.carry_out(&packet.command, log, watchdog) {
            Ok(answer) => answer,
            Err(refusal) => {
                self.counters.refused = self.counters.refused.wrapping_add(1);
                Answer::Refused(refusal)
            }
        };
        self.answer(packet.sequence, answer);
    }

    fn hello(&mut self) -> Answer {
        // The tick count makes a number that no session before it had, short of a reset; after one nothing runs.
        let tick = tick::with(|tick| tick.now().1).unwrap_or_default();
        let number = self.session.as_ref().map_or(tick, |session| session.number.wrapping_add(1).max(tick));
        self.session = Some(Session { number, last_sequence: 0 });
        Answer::Hello {
            session: number,
            protocol: PROTOCOL,
            frame_schema: FRAME_SCHEMA,
            parameters: parameters::TABLE.len() as u8,
            build: log::build(),
        }
    }

    fn answer(&mut self, sequence: u32, answer: Answer) {
        let mut packet = [0; PACKET_BYTES];
        let Ok(bytes) = er_servo::link::encode(&Reply { sequence, answer }, &mut packet) else { return };
        // Whole or not at all.
        if OUT_BYTES - self.out.len() >= bytes.len() {
            for byte in bytes {
                let _ = self.out.push_back(*byte);
            }
        }
    }

    fn carry_out(
        &mut self,
        command: &Command,
        log: &mut Log,
        watchdog: &mut IndependentWatchdog,
    ) -> Result<Answer, Refusal> {
        match *command {
            // Handled before, as it has no session.
            Command::Hello => Ok(Answer::Done),
            Command::Enable => self.request(Request::Enable),
            Command::Disable => self.request(Request::Disable),
            Command::ClearFault => self.clear(),
            Command::Reference { counts } => self.while_running(|tick| tick.follow(Counts(counts))),
            Command::Hold => self.while_running(tick::Tick::end_experiment),
            Command::Run(experiment) => {
                let sequence = experiment.start(self.config.period_s).map_err(|_| Refusal::Value)?;
                self.while_running(tick::Tick::end_experiment)?;
                self.sequence = Some(sequence);
                self.compute_ahead();
                self.while_running(tick::Tick::experiment)
            }
            Command::ReadParameter { index } => {
                let parameter = parameters::TABLE.get(usize::from(index)).ok_or(Refusal::Index)?;
                Ok(Answer::Parameter { value: (parameter.get)(&self.staged) })
            }
            Command::WriteParameter { index, value } => self.write(index, value),
            Command::Apply => self.apply(log),
            Command::Defaults => {
                self.staged = Config::default();
                Ok(Answer::Done)
            }
            Command::Load => {
                self.staged = self.storage.load().map_err(refusal)?;
                Ok(Answer::Done)
            }
            Command::Save => self.save(log, watchdog),
            Command::StartRecording { run } => self.record(run, log),
            Command::StopRecording => {
                log.stop_recording();
                Ok(Answer::Done)
            }
            Command::Status => self.status(log).ok_or(Refusal::NotRunning),
        }
    }

    fn supervisor(&self) -> Supervisor {
        tick::with(|tick| tick.now().0.supervisor()).unwrap_or_default()
    }

    fn request(&mut self, request: Request) -> Result<Answer, Refusal> {
        tick::with(|tick| tick.request(request));
        Ok(Answer::Done)
    }

    fn while_running(&mut self, act: impl FnOnce(&mut tick::Tick)) -> Result<Answer, Refusal> {
        if self.supervisor() != Supervisor::Running {
            return Err(Refusal::NotRunning);
        }
        tick::with(act);
        Ok(Answer::Done)
    }

    fn idle(&self, log: &Log) -> Result<(), Refusal> {
        if self.supervisor() == Supervisor::Running {
            return Err(Refusal::Running);
        }
        if log.recording() { Err(Refusal::Recording) } else { Ok(()) }
    }

    /// Brings chips that failed up again first, with ticks paused: the drive is in its safe state meanwhile.
    fn clear(&mut self) -> Result<Answer, Refusal> {
        let hardware = Faults::RESOLVER_CHIP | Faults::RESOLVER_BUS | Faults::OUTPUT_BUS;
        if self.supervisor().faults().intersects(hardware)
            && let Some(Err(error)) = tick::paused(|| tick::with(tick::Tick::init))
        {
            log::init_failed(&error);
            return Err(Refusal::Hardware);
        }
        self.request(Request::ClearFault)
    }

    fn write(&mut self, index: u8, value: f32) -> Result<Answer, Refusal> {
        let parameter = parameters::TABLE.get(usize::from(index)).ok_or(Refusal::Index)?;
        if !(parameter.min..=parameter.max).contains(&value) {
            return Err(Refusal::Value);
        }
        (parameter.set)(&mut self.staged, value);
        Ok(Answer::Done)
    }

    fn apply(&mut self, log: &Log) -> Result<Answer, Refusal> {
        self.idle(log)?;
        let params = Params::new(&self.staged).map_err(|_| Refusal::Value)?;
        match tick::with(|tick| tick.set_params(params)) {
            Some(Ok(())) => {
                self.config = self.staged;
                Ok(Answer::Done)
            }
            _ => Err(Refusal::Running),
        }
    }

    fn save(&mut self, log: &Log, watchdog: &mut IndependentWatchdog) -> Result<Answer, Refusal> {
        self.idle(log)?;
        self.storage.save(&self.config, watchdog).map_err(refusal)?;
        Ok(Answer::Done)
    }

    fn record(&mut self, run: u32, log: &mut Log) -> Result<Answer, Refusal> {
        if log.recording() {
            return Err(Refusal::Recording);
        }
        let (state, seq, _) = tick::with(|tick| tick.now()).ok_or(Refusal::NotRunning)?;
        log.start_recording(run, seq, &state, &self.config);
        Ok(Answer::Done)
    }

    fn status(&self, log: &Log) -> Option<Answer> {
        let frame = self.last?;
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
            recording: log.recording(),
            counters: self.counters,
        }))
    }
}

fn refusal(error: StorageError) -> Refusal {
    match error {
        StorageError::Flash => Refusal::Storage,
        StorageError::Empty | StorageError::Unusable => Refusal::NothingStored,
    }
}
