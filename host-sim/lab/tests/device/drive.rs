//! A drive on the simulated plant, with the image's log, and all that its link server asks of it.

use er_servo::events::Event;
use er_servo::experiment::Sequence;
use er_servo::host_sim::Bench;
use er_servo::link::TELEMETRY_BYTES;
use er_servo::link::{Commander, Drive, Offset, Pace, Refusal};
use er_servo::motion::MotionLimits;
use er_servo::storage::StorageError;
use er_servo::telemetry::{self, Begin, Packer};
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
    /// The next clear has to make room in the event log.
    pub log_is_full: bool,
    /// What it has sent over the link beside its answers, since somebody took it.
    pub telemetry: Vec<u8>,
    packer: Option<Packer>,
    encoder: Option<Encoder>,
    commander: Commander,
    sequence: Option<Sequence>,
    stored: Option<Config>,
    recording: bool,
    next: u32,
    random: u32,
    events: Vec<Event>,
}

impl Machine {
    /// Up and ready.
    pub fn ready(encoder: Option<Encoder>) -> Self {
        Self::of(&Model::paper(), encoder, SILENT_TICKS)
    }

    /// Another machine, up and ready.
    pub fn of(model: &Model, encoder: Option<Encoder>, silent_ticks: u32) -> Self {
        let config = Config::default();
        let mut bench = Bench::new(model, Params::new(&config).unwrap(), f64::from(config.period_s)).unwrap();
        bench.init().unwrap();
        let commander = Commander::new(Faults::empty(), silent_ticks);
        let mut machine = Self {
            bench,
            last: None,
            log: Vec::new(),
            lose: 0,
            log_is_full: false,
            telemetry: Vec::new(),
            packer: None,
            encoder,
            commander,
            sequence: None,
            stored: None,
            recording: false,
            next: 0,
            random: 1,
            events: Vec::new(),
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
        let orders = commander.orders(bench.servo.state(), bench.servo.params().motion(), offset);
        let frame = bench.tick(&orders).unwrap();
        if self.recording && self.lose == 0 {
            self.record(&frame);
        }
        self.lose = self.lose.saturating_sub(1);
        let before = self.last.map_or(Faults::empty(), |last| last.outputs.supervisor.faults());
        let faults = frame.outputs.supervisor.faults().bits();
        if before.is_empty() && faults != 0 {
            self.events.push(Event { number: self.events.len() as u32, faults, ..Event::default() });
        }
        self.next = frame.seq.wrapping_add(1);
        self.last = Some(frame);
    }

    fn record(&mut self, frame: &Frame) {
        let Some(packer) = &mut self.packer else {
            self.log.extend(self.encoder.iter().flat_map(|encoder| encoder.frame(frame)));
            return;
        };
        if !packer.push(frame) {
            self.telemetry.extend(packer.finish(&mut [0; TELEMETRY_BYTES]).unwrap());
            assert!(packer.push(frame));
        }
    }

    /// A log of one run: enabled, a step of the reference, ended.
    pub fn record_step(&mut self, run: u32, ticks: u32) {
        self.start(run, 20);
        self.finish(ticks);
    }

    /// The begin of a run, and so many ticks of it.
    pub fn start(&mut self, run: u32, ticks: u32) {
        self.start_recording(run, false, &Config::default());
        self.enable(true);
        self.ticks(ticks);
        self.heard();
        self.follow(Counts(5_000), &Pace::default(), 0);
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

    fn random(&mut self) -> u32 {
        self.random = self.random.wrapping_add(1);
        self.random
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

    fn link_alive(&self) -> bool {
        self.commander.link_alive()
    }

    fn enable(&mut self, autonomous: bool) {
        self.commander.enable(autonomous);
    }

    fn set_position(&mut self, position: Counts) {
        self.commander.set_position(position);
    }

    fn target(&self) -> Counts {
        self.commander.target()
    }

    fn follow(&mut self, target: Counts, pace: &Pace, torque_bound_nm: u8) {
        self.sequence = None;
        self.commander.follow(target, self.bench.servo.params().motion(), pace, torque_bound_nm);
    }

    fn hold(&mut self, autonomous: bool) {
        self.sequence = None;
        self.commander.hold(autonomous);
    }

    fn run(&mut self, sequence: Sequence, torque_bound_nm: u8, autonomous: bool) {
        self.sequence = Some(sequence);
        self.commander.experiment(autonomous, torque_bound_nm);
    }

    fn motion(&self) -> MotionLimits {
        *self.bench.servo.params().motion()
    }

    fn reinitialise(&mut self) -> Result<(), Refusal> {
        self.bench.init().map_err(|_| Refusal::Hardware)
    }

    fn set_params(&mut self, params: Params, _: bool) -> Result<(), Supervisor> {
        self.bench.servo.set_params(params)
    }

    fn load(&mut self) -> Result<Config, StorageError> {
        self.stored.ok_or(StorageError::Empty)
    }

    fn save(&mut self, config: &Config) -> Result<(), StorageError> {
        self.stored = Some(*config);
        Ok(())
    }

    fn event(&mut self, back: u8) -> Option<Event> {
        self.events.iter().rev().nth(back.into()).copied()
    }

    fn make_room_for_events(&mut self) {
        if std::mem::take(&mut self.log_is_full) {
            self.bench.servo.pause();
        }
    }

    fn recording(&self) -> bool {
        self.recording
    }

    fn start_recording(&mut self, run: u32, over_link: bool, config: &Config) {
        self.recording = true;
        self.packer = over_link.then(Packer::default);
        if over_link {
            let (build, tick, state) = (self.build(), self.next, self.state());
            let begin = Begin { run, build, tick, state, config: *config };
            self.telemetry.extend(begin.encode(&mut [0; TELEMETRY_BYTES]));
        } else if let Some(encoder) = &self.encoder {
            self.log.extend(encoder.begin(run, self.next, self.bench.servo.state(), config));
        }
    }

    fn stop_recording(&mut self) {
        match (self.packer.take(), &self.encoder) {
            (Some(mut packer), _) => {
                let mut packet = [0; TELEMETRY_BYTES];
                self.telemetry.extend(packer.finish(&mut packet).unwrap_or_default());
                self.telemetry.extend(telemetry::end(&mut packet));
            }
            (None, Some(encoder)) if self.recording => self.log.extend(encoder.end()),
            _ => {}
        }
        self.recording = false;
    }
}
