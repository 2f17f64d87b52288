//! A drive on the simulated plant, with the image's log, and all that its link server asks of it.

use er_servo::experiment::Sequence;
use er_servo::host_sim::Bench;
use er_servo::link::{Commander, Drive, Offset, Refusal};
use er_servo::storage::StorageError;
use er_servo::{Config, Counts, Faults, Frame, Params, Request, State, Supervisor};
use plant::Model;

use crate::log::Encoder;

/// Ticks of silence after which a reference from the link is a fault, as in the image.
const SILENT_TICKS: u32 = 500;

/// The drive.
pub struct Machine {
    pub bench: Bench,
    pub last: Option<Frame>,
    /// What the log has written since somebody took it; empty without an encoder.
    pub log: Vec<u8>,
    /// Ticks whose frames the log loses from now on.
    pub lose: u32,
    encoder: Option<Encoder>,
    commander: Commander,
    sequence: Option<Sequence>,
    stored: Option<Config>,
    recording: bool,
    next: u32,
}

impl Machine {
    /// Up and ready.
    pub fn ready(encoder: Option<Encoder>) -> Self {
        let config = Config::default();
        let mut bench = Bench::new(&Model::paper(), Params::new(&config).unwrap(), f64::from(config.period_s)).unwrap();
        bench.init().unwrap();
        let commander = Commander::new(Faults::empty(), SILENT_TICKS);
        let mut machine = Self {
            bench,
            last: None,
            log: Vec::new(),
            lose: 0,
            encoder,
            commander,
            sequence: None,
            stored: None,
            recording: false,
            next: 0,
        };
        machine.ticks(100);
        assert_eq!(machine.state().supervisor(), Supervisor::Ready);
        machine
    }

    pub fn ticks(&mut self, count: u32) {
        (0..count).for_each(|_| self.tick());
    }

    fn tick(&mut self) {
        let Self { sequence, commander, bench, .. } = self;
        let offset = || sequence.as_mut().map(|sequence| sequence.next().map_or(Offset::End, Offset::Counts));
        let orders = commander.orders(bench.servo.state(), offset);
        let frame = bench.tick(&orders).unwrap();
        if let (Some(encoder), true, 0) = (&self.encoder, self.recording, self.lose) {
            self.log.extend(encoder.frame(&frame));
        }
        self.lose = self.lose.saturating_sub(1);
        self.next = frame.seq.wrapping_add(1);
        self.last = Some(frame);
    }

    /// A log of one run: enabled, a step of the reference, ended.
    pub fn record_step(&mut self, run: u32, ticks: u32) {
        self.start(run, 20);
        self.finish(ticks);
    }

    /// The begin of a run, and so many ticks of it.
    pub fn start(&mut self, run: u32, ticks: u32) {
        self.start_recording(run, &Config::default());
        self.request(Request::Enable);
        self.ticks(ticks);
        self.heard();
        self.follow(Counts(5_000));
    }

    /// The rest of a run: so many ticks of a step, shorter than the patience with the link, and the end.
    pub fn finish(&mut self, ticks: u32) {
        self.ticks(ticks);
        self.request(Request::Disable);
        self.ticks(5);
        self.stop_recording();
    }
}

impl Drive for Machine {
    fn build(&self) -> [u8; 8] {
        self.encoder.as_ref().map_or(*b"er-servo", |encoder| encoder.build)
    }

    fn tick(&self) -> u32 {
        self.next
    }

    fn state(&self) -> State {
        *self.bench.servo.state()
    }

    fn last_frame(&self) -> Option<Frame> {
        self.last
    }

    fn heard(&mut self) {
        self.commander.heard();
    }

    fn request(&mut self, request: Request) {
        self.commander.request(request);
    }

    fn follow(&mut self, reference: Counts) {
        self.hold();
        self.commander.follow(reference);
    }

    fn hold(&mut self) {
        self.sequence = None;
        self.commander.hold();
    }

    fn run(&mut self, sequence: Sequence) {
        self.hold();
        self.sequence = Some(sequence);
        self.commander.experiment();
    }

    fn reinitialise(&mut self) -> Result<(), Refusal> {
        self.bench.init().map_err(|_| Refusal::Hardware)
    }

    fn set_params(&mut self, params: Params) -> Result<(), Supervisor> {
        self.bench.servo.set_params(params)
    }

    fn load(&mut self) -> Result<Config, StorageError> {
        self.stored.ok_or(StorageError::Empty)
    }

    fn save(&mut self, config: &Config) -> Result<(), StorageError> {
        self.stored = Some(*config);
        Ok(())
    }

    fn recording(&self) -> bool {
        self.recording
    }

    fn start_recording(&mut self, run: u32, config: &Config) {
        self.recording = true;
        if let Some(encoder) = &self.encoder {
            self.log.extend(encoder.begin(run, self.next, self.bench.servo.state(), config));
        }
    }

    fn stop_recording(&mut self) {
        if let (Some(encoder), true) = (&self.encoder, self.recording) {
            self.log.extend(encoder.end());
        }
        self.recording = false;
    }
}
