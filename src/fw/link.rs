//! The command link in thread mode. Bytes come in by DMA into a ring, so that none of them costs the tick anything; what
//! they mean is the library's [`Server`], what they act on is here.

use embedded_hal_nb::serial::Write;
use er_servo::events::{Event, Restart};
use er_servo::experiment::Sequence;
use er_servo::link::{Drive, Offset, PACKET_BYTES, Pace, Refusal, Reply, Server, TELEMETRY_BYTES};
use er_servo::motion::MotionLimits;
use er_servo::storage::StorageError;
use er_servo::telemetry::{self, Begin, Packer};
use er_servo::{Config, Counts, Faults, Frame, Params, Request, State, Supervisor};
use heapless::Deque;
use heapless::spsc::Producer;
use stm32f4xx_hal::pac::USART2;
use stm32f4xx_hal::serial::Tx;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

use super::board::{QUEUE_OFFSETS, Ring};
use super::clock::Random;
use super::log::{self, Log};
use super::storage::Storage;
use super::tick;

/// Bytes that wait for the line: answers, and frames for 20 ms. More are dropped; the host asks again, and finds a gap.
const OUT_BYTES: usize = 8 * TELEMETRY_BYTES;
/// Bytes handled at a time, before frames and watchdog have their turn again: more than the line brings in two ticks.
const POLL_BYTES: usize = 128;

/// The link and what it acts on.
pub struct Link {
    ring: Ring,
    tx: Tx<USART2>,
    out: Out,
    telemetry: Telemetry,
    server: Server,
    storage: Storage,
    random: Random,
    /// What the reset before this start is put down to.
    restart: Restart,
    last: Option<Frame>,
    ahead: Ahead,
    /// The last packet took long: none is handled before a tick has come.
    ticks_first: bool,
}

impl Link {
    /// With a server that knows the parameters the law was started with; `restart` is for the event of an abnormal reset.
    pub fn new(
        ring: Ring,
        tx: Tx<USART2>,
        storage: Storage,
        server: Server,
        offsets: Producer<'static, Offset, QUEUE_OFFSETS>,
        restart: Restart,
    ) -> Self {
        let ahead = Ahead { sequence: None, offsets };
        let (out, telemetry) = (Out::new(), Telemetry::default());
        let random = Random::default();
        Self { ring, tx, out, telemetry, server, storage, random, restart, last: None, ahead, ticks_first: false }
    }

    /// Takes note of a tick, for the status, and of a fault, for the event log.
    pub fn frame(&mut self, frame: &Frame) {
        let was_fault = self.last.is_some_and(|last| matches!(last.outputs.supervisor, Supervisor::Fault { .. }));
        if let (Supervisor::Fault { faults }, false) = (frame.outputs.supervisor, was_fault) {
            let restart = faults.contains(Faults::ABNORMAL_RESET).then_some(self.restart);
            self.storage.log_event(&Event { restart, ..event(frame, faults) });
        }
        self.telemetry.frame(frame, &mut self.out);
        self.last = Some(*frame);
        self.ticks_first = false;
    }

    /// Handles what came in since the last time, and sends on; never waits.
    pub fn poll(&mut self, log: &mut Log, watchdog: &mut IndependentWatchdog) {
        for _ in 0..POLL_BYTES {
            // Two packets in a row that each pause the ticks for 45 ms would outlast the watchdog.
            let Some(byte) = (if self.ticks_first { None } else { self.ring.next() }) else { break };
            let (storage, last, ahead) = (&mut self.storage, self.last.as_ref(), &mut self.ahead);
            let (telemetry, out, random) = (&mut self.telemetry, &mut self.out, &mut self.random);
            let mut image = Image { log, watchdog, storage, random, last, ahead, telemetry, out, paused: false };
            let reply = self.server.push(byte, &mut image);
            self.ticks_first = image.paused;
            if let Some(reply) = reply {
                answer(&mut self.out, &reply);
            }
        }
        self.ahead.fill();
        while let Some(byte) = self.out.front() {
            match self.tx.write(*byte) {
                Err(nb::Error::WouldBlock) => break,
                // A byte the line refused is gone; the host's check finds it.
                _ => self.out.pop_front(),
            };
        }
    }

    /// Whether an answer is on its way.
    pub fn sending(&self) -> bool {
        !self.out.is_empty()
    }
}

/// A fault, for the event log.
fn event(frame: &Frame, faults: Faults) -> Event {
    Event {
        number: 0,
        faults: faults.bits(),
        at_ms: frame.seq / tick::TICKS_PER_MS,
        position: frame.outputs.position.0,
        speed_rad_s: frame.outputs.speed_rad_s,
        worst_cycles: frame.timing.worst_cycles,
        resolver_faults: frame.inputs.resolver.fault_byte,
        restart: None,
    }
}

/// What waits for the line.
type Out = Deque<u8, OUT_BYTES>;

/// Puts an answer behind those that wait, whole or not at all.
fn answer(out: &mut Out, reply: &Reply) {
    let mut packet = [0; PACKET_BYTES];
    if let Ok(bytes) = er_servo::link::encode(reply, &mut packet) {
        put(out, bytes, 0);
    }
}

/// Puts a packet behind those that wait if so many bytes stay free then.
fn put(out: &mut Out, packet: &[u8], leave_bytes: usize) {
    if OUT_BYTES - out.len() >= packet.len() + leave_bytes {
        for byte in packet {
            let _ = out.push_back(*byte);
        }
    }
}

/// A recording over the link.
#[derive(Default)]
struct Telemetry {
    packer: Packer,
    /// First tick of the recording that runs.
    recording: Option<u32>,
}

impl Telemetry {
    fn begin(&mut self, begin: &Begin, out: &mut Out) {
        self.packer = Packer::default();
        self.recording = Some(begin.tick);
        if OUT_BYTES - out.len() < TELEMETRY_BYTES {
            // A flood of commands filled it; a recording without its begin is none.
            out.clear();
        }
        put(out, begin.encode(&mut [0; TELEMETRY_BYTES]), 0);
    }

    fn frame(&mut self, frame: &Frame, out: &mut Out) {
        // Frames that were queued before the snapshot was taken are not part of the recording.
        let is_of_it = self.recording.is_some_and(|first| frame.seq.wrapping_sub(first) < u32::MAX / 2);
        if is_of_it && !self.packer.push(frame) {
            self.flush(out);
            self.packer.push(frame);
        }
    }

    fn flush(&mut self, out: &mut Out) {
        if let Some(packet) = self.packer.finish(&mut [0; TELEMETRY_BYTES]) {
            // An answer must find room beside frames that the line does not keep up with.
            put(out, packet, PACKET_BYTES);
        }
    }

    fn end(&mut self, out: &mut Out) {
        if self.recording.take().is_some() {
            self.flush(out);
            put(out, telemetry::end(&mut [0; TELEMETRY_BYTES]), 0);
        }
    }
}

/// The experiment that runs, computed ahead of the ticks.
struct Ahead {
    sequence: Option<Sequence>,
    offsets: Producer<'static, Offset, QUEUE_OFFSETS>,
}

impl Ahead {
    /// Keeps the queue of offsets full.
    fn fill(&mut self) {
        while self.offsets.ready() {
            let Some(sequence) = &mut self.sequence else { return };
            let offset = sequence.next().map_or(Offset::End, Offset::Counts);
            if offset == Offset::End {
                self.sequence = None;
            }
            let _ = self.offsets.enqueue(offset);
        }
    }
}

/// What the commands act on.
struct Image<'a> {
    log: &'a mut Log,
    watchdog: &'a mut IndependentWatchdog,
    storage: &'a mut Storage,
    random: &'a mut Random,
    last: Option<&'a Frame>,
    ahead: &'a mut Ahead,
    telemetry: &'a mut Telemetry,
    out: &'a mut Out,
    /// Ticks were paused.
    paused: bool,
}

impl Image<'_> {
    fn end_experiment(&mut self) {
        self.ahead.sequence = None;
        tick::with(tick::Tick::forget_offsets);
    }
}

impl Drive for Image<'_> {
    fn build(&self) -> [u8; 8] {
        log::build()
    }

    fn random(&mut self) -> u32 {
        self.random.number()
    }

    fn state(&self) -> State {
        tick::with(|tick| tick.now().0).unwrap_or_default()
    }

    fn last_frame(&self) -> Option<Frame> {
        self.last.copied()
    }

    fn heard(&mut self) {
        tick::with(|tick| tick.commander.heard());
    }

    fn request(&mut self, request: Request) {
        tick::with(|tick| tick.commander.request(request));
    }

    fn link_alive(&self) -> bool {
        tick::with(|tick| tick.commander.link_alive()).unwrap_or_default()
    }

    fn enable(&mut self, autonomous: bool) {
        tick::with(|tick| tick.commander.enable(autonomous));
    }

    fn set_position(&mut self, position: Counts) {
        tick::with(|tick| tick.commander.set_position(position));
    }

    fn target(&self) -> Counts {
        tick::with(|tick| tick.commander.target()).unwrap_or_default()
    }

    fn follow(&mut self, target: Counts, pace: &Pace, torque_bound_nm: u8) {
        self.end_experiment();
        tick::with(|tick| tick.follow(target, pace, torque_bound_nm));
    }

    fn hold(&mut self, autonomous: bool) {
        self.end_experiment();
        tick::with(|tick| tick.commander.hold(autonomous));
    }

    fn run(&mut self, sequence: Sequence, torque_bound_nm: u8, autonomous: bool) {
        self.end_experiment();
        self.ahead.sequence = Some(sequence);
        self.ahead.fill();
        tick::with(|tick| tick.commander.experiment(autonomous, torque_bound_nm));
    }

    fn reinitialise(&mut self) -> Result<(), Refusal> {
        self.paused = true;
        match tick::paused(|| tick::with(tick::Tick::init)) {
            Some(Err(error)) => {
                log::init_failed(&error);
                Err(Refusal::Hardware)
            }
            _ => Ok(()),
        }
    }

    fn motion(&self) -> MotionLimits {
        // There is a tick before there is a link.
        tick::with(|tick| tick.motion()).unwrap_or_default()
    }

    fn set_params(&mut self, params: Params, forced: bool) -> Result<(), Supervisor> {
        if forced {
            log::forced();
        }
        tick::with(|tick| tick.set_params(params)).unwrap_or(Err(Supervisor::default()))
    }

    fn load(&mut self) -> Result<Config, StorageError> {
        self.storage.load()
    }

    fn save(&mut self, config: &Config) -> Result<(), StorageError> {
        self.paused = true;
        self.storage.save(config, self.watchdog)
    }

    fn event(&mut self, back: u8) -> Option<Event> {
        self.storage.event(back)
    }

    fn make_room_for_events(&mut self) {
        if self.storage.events_are_full() {
            self.paused = true;
            self.storage.make_room_for_events(self.watchdog);
        }
    }

    fn recording(&self) -> bool {
        self.log.recording() || self.telemetry.recording.is_some()
    }

    fn start_recording(&mut self, run: u32, over_link: bool, config: &Config) {
        let Some((state, tick)) = tick::with(|tick| tick.now()) else { return };
        if over_link {
            self.telemetry.begin(&Begin { run, build: log::build(), tick, state, config: *config }, self.out);
        } else {
            self.log.start_recording(run, tick, &state, config);
        }
    }

    fn stop_recording(&mut self) {
        self.log.stop_recording();
        self.telemetry.end(self.out);
    }
}
