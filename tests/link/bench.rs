//! A law that ticks when the server asks for something, and what it asked for.

use er_servo::events::Event;
use er_servo::experiment::Sequence;
use er_servo::link::{Drive, Pace, Refusal};
use er_servo::motion::MotionLimits;
use er_servo::storage::StorageError;
use er_servo::{Config, Counts, Faults, Frame, InputFlags, Inputs, Params, Request, State, Supervisor, Timing, step};

/// What the server asked for, and a law that ticks.
pub struct Bench {
    pub params: Params,
    pub state: State,
    pub frame: Option<Frame>,
    pub flags: InputFlags,
    pub tick: u32,
    pub stored: Option<Config>,
    pub recording: Option<(u32, Config)>,
    pub asked: Vec<&'static str>,
    pub chips_fail: bool,
    pub alive: bool,
    pub random: u32,
}

impl Bench {
    pub fn new() -> Self {
        Self {
            params: Params::new(&Config::default()).unwrap(),
            state: State::default(),
            frame: None,
            flags: InputFlags::INTERLOCK_CLOSED | InputFlags::AMPLIFIER_READY | InputFlags::LINK_ALIVE,
            tick: 0,
            stored: None,
            recording: None,
            asked: Vec::new(),
            chips_fail: false,
            alive: true,
            random: 1,
        }
    }

    /// Ticks with a request and faults from outside.
    pub fn ticks(&mut self, count: u32, request: Request, reported: Faults) {
        for nth in 0..count {
            let request = if nth == 0 { request } else { Request::None };
            let inputs = Inputs { flags: self.flags, request, reported, ..Inputs::default() };
            let outputs = step(&self.params, &mut self.state, &inputs);
            self.frame = Some(Frame { seq: self.tick, lost: 0, inputs, outputs, timing: Timing::default() });
            self.tick += 1;
        }
    }

    /// The last thing that was asked, beside being heard.
    pub fn last_asked(&self) -> &'static str {
        self.asked.iter().rev().find(|asked| **asked != "heard").copied().unwrap_or_default()
    }

    pub fn ready() -> Self {
        let mut bench = Self::new();
        bench.ticks(100, Request::None, Faults::empty());
        assert_eq!(bench.state.supervisor(), Supervisor::Ready);
        bench
    }

    pub fn running() -> Self {
        let mut bench = Self::ready();
        bench.ticks(1, Request::Enable, Faults::empty());
        assert_eq!(bench.state.supervisor(), Supervisor::Running);
        bench
    }
}

impl Drive for Bench {
    fn build(&self) -> [u8; 8] {
        *b"er-servo"
    }

    fn random(&mut self) -> u32 {
        self.random = self.random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.random
    }

    fn state(&self) -> State {
        self.state
    }

    fn last_frame(&self) -> Option<Frame> {
        self.frame
    }

    fn heard(&mut self) {
        self.asked.push("heard");
    }

    fn request(&mut self, request: Request) {
        self.asked.push("request");
        self.ticks(1, request, Faults::empty());
    }

    fn link_alive(&self) -> bool {
        self.alive
    }

    fn enable(&mut self, _: bool) {
        self.request(Request::Enable);
    }

    fn set_position(&mut self, position: Counts) {
        let request = Request::SetPosition;
        let inputs = Inputs { flags: self.flags, request, reference: position, ..Inputs::default() };
        step(&self.params, &mut self.state, &inputs);
    }

    fn target(&self) -> Counts {
        self.state.position()
    }

    fn follow(&mut self, _: Counts, _: &Pace, _: u8) {
        self.asked.push("follow");
    }

    fn hold(&mut self, _: bool) {
        self.asked.push("hold");
    }

    fn run(&mut self, _: Sequence, _: u8, _: bool) {
        self.asked.push("run");
    }

    fn reinitialise(&mut self) -> Result<(), Refusal> {
        self.asked.push("reinitialise");
        if self.chips_fail { Err(Refusal::Hardware) } else { Ok(()) }
    }

    fn set_params(&mut self, params: Params, forced: bool) -> Result<(), Supervisor> {
        self.asked.push(if forced { "forced" } else { "set" });
        self.params = params;
        Ok(())
    }

    fn motion(&self) -> MotionLimits {
        *self.params.motion()
    }

    fn load(&mut self) -> Result<Config, StorageError> {
        self.stored.ok_or(StorageError::Empty)
    }

    fn save(&mut self, config: &Config) -> Result<(), StorageError> {
        self.stored = Some(*config);
        Ok(())
    }

    fn event(&mut self, back: u8) -> Option<Event> {
        let newest = Event { number: 1, faults: 2, at_ms: 3, position: 4, ..Event::default() };
        (back < 2).then(|| Event { number: newest.number - u32::from(back), ..newest })
    }

    fn make_room_for_events(&mut self) {
        self.asked.push("make room");
        assert!(matches!(self.state.supervisor(), Supervisor::Fault { .. }));
    }

    fn recording(&self) -> bool {
        self.recording.is_some()
    }

    fn start_recording(&mut self, run: u32, _: bool, config: &Config) {
        self.recording = Some((run, *config));
    }

    fn stop_recording(&mut self) {
        self.recording = None;
    }
}
