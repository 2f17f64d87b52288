//! The command link in thread mode. Bytes come in by DMA into a ring, so that none of them costs the tick anything; what
//! they mean is the library's [`Server`], what they act on is here.

use embedded_hal_nb::serial::Write;
use er_servo::experiment::Sequence;
use er_servo::link::{Drive, Offset, PACKET_BYTES, Refusal, Reply, Server};
use er_servo::storage::StorageError;
use er_servo::{Config, Counts, Frame, Params, Request, State, Supervisor};
use heapless::Deque;
use heapless::spsc::Producer;
use stm32f4xx_hal::pac::USART2;
use stm32f4xx_hal::serial::Tx;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

use super::board::{QUEUE_OFFSETS, Ring};
use super::log::{self, Log};
use super::storage::Storage;
use super::tick;

/// Bytes of answers that wait for the line; more are dropped, the host asks again.
const OUT_BYTES: usize = 4 * PACKET_BYTES;
/// Bytes handled at a time, before frames and watchdog have their turn again: more than the line brings in two ticks.
const POLL_BYTES: usize = 128;

/// The link and what it acts on.
pub struct Link {
    ring: Ring,
    tx: Tx<USART2>,
    out: Deque<u8, OUT_BYTES>,
    server: Server,
    storage: Storage,
    last: Option<Frame>,
    ahead: Ahead,
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
        let (out, server) = (Deque::new(), Server::new(config));
        Self { ring, tx, out, server, storage, last: None, ahead: Ahead { sequence: None, offsets } }
    }

    /// Takes note of a tick, for the status.
    pub fn frame(&mut self, frame: &Frame) {
        self.last = Some(*frame);
    }

    /// Handles what came in since the last time, and sends on; never waits.
    pub fn poll(&mut self, log: &mut Log, watchdog: &mut IndependentWatchdog) {
        for byte in self.ring.by_ref().take(POLL_BYTES) {
            let (storage, last, ahead) = (&mut self.storage, self.last.as_ref(), &mut self.ahead);
            if let Some(reply) = self.server.push(byte, &mut Image { log, watchdog, storage, last, ahead }) {
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

/// Puts an answer behind those that wait, whole or not at all.
fn answer(out: &mut Deque<u8, OUT_BYTES>, reply: &Reply) {
    let mut packet = [0; PACKET_BYTES];
    let Ok(bytes) = er_servo::link::encode(reply, &mut packet) else { return };
    if OUT_BYTES - out.len() >= bytes.len() {
        for byte in bytes {
            let _ = out.push_back(*byte);
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
    last: Option<&'a Frame>,
    ahead: &'a mut Ahead,
}

impl Drive for Image<'_> {
    fn build(&self) -> [u8; 8] {
        log::build()
    }

    fn tick(&self) -> u32 {
        tick::with(|tick| tick.now().1).unwrap_or_default()
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

    fn follow(&mut self, reference: Counts) {
        self.hold();
        tick::with(|tick| tick.commander.follow(reference));
    }

    fn hold(&mut self) {
        self.ahead.sequence = None;
        tick::with(tick::Tick::end_experiment);
    }

    fn run(&mut self, sequence: Sequence) {
        self.hold();
        self.ahead.sequence = Some(sequence);
        self.ahead.fill();
        tick::with(|tick| tick.commander.experiment());
    }

    fn reinitialise(&mut self) -> Result<(), Refusal> {
        match tick::paused(|| tick::with(tick::Tick::init)) {
            Some(Err(error)) => {
                log::init_failed(&error);
                Err(Refusal::Hardware)
            }
            _ => Ok(()),
        }
    }

    fn set_params(&mut self, params: Params) -> Result<(), Supervisor> {
        tick::with(|tick| tick.set_params(params)).unwrap_or(Err(Supervisor::default()))
    }

    fn load(&mut self) -> Result<Config, StorageError> {
        self.storage.load()
    }

    fn save(&mut self, config: &Config) -> Result<(), StorageError> {
        self.storage.save(config, self.watchdog)
    }

    fn recording(&self) -> bool {
        self.log.recording()
    }

    fn start_recording(&mut self, run: u32, config: &Config) {
        if let Some((state, seq)) = tick::with(|tick| tick.now()) {
            self.log.start_recording(run, seq, &state, config);
        }
    }

    fn stop_recording(&mut self) {
        self.log.stop_recording();
    }
}
