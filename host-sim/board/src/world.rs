//! Everything around the MCU: the rotor behind the chips, what a test does to the board and when, and what was seen.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use plant::chips::Chip;
use plant::chips::ad2s1210::Pin as ResolverPin;
use plant::chips::dac::Pin as DacPin;
use rigless::emulator::{AccessKind, Driver, Host, Settled, Stop, Watch};
use rigless::session::Session;
use rigless::time::VirtualNanos;

use crate::core::Hand;
use crate::flash::Shared;
use crate::host::Host as LinkHost;
use crate::machine::{Port, ServoBoard};
use crate::rotor::Rotor;
use crate::rtt::Probe;
use crate::tcp::Port as TcpPort;
use crate::terminal::BYTE_NS;

/// Longest way between two looks at the world, ns: one tick. The rotor does not depend on it: it is moved exactly to every
/// sample and every change of command.
const STRIDE_NS: u64 = 500_000;
/// With a client, who may stay for days, what was seen is forgotten after so many ticks: a minute.
const KEPT_TICKS: usize = 120_000;
/// Registers of the ports A to C.
const PORTS: std::ops::Range<u64> = 0x4002_0000..0x4002_0C00;

/// Registers of the timer whose channels are pins.
const TIM3: std::ops::Range<u64> = 0x4000_0400..0x4000_0800;

/// Mode of LDAC's channel, and the value with which it falls at the next match.
const TIM3_CCMR1: u64 = 0x4000_0418;
const FALLS_AT_MATCH: u64 = 0b010 << 4;

/// First register of port C.
const PORT_C: u64 = 0x4002_0800;
/// Registers of the first converter.
const ADC1: std::ops::Range<u64> = 0x4001_2000..0x4001_2100;

/// PC1, interlock; PC2, stop released.
pub const INTERLOCK: (Port, u8) = (Port::C, 1);
/// High: the stop is released.
pub const STOP_RELEASED: (Port, u8) = (Port::C, 2);
/// High: the motor's amplifier is ready.
pub const AMPLIFIER_READY: (Port, u8) = (Port::C, 4);
/// An edge in every tick; what it feeds is [`MONOSTABLE_NS`].
const HEARTBEAT: (Port, u8) = (Port::C, 5);
/// The monostable outside takes torque and high voltage off without an edge of the heartbeat for this long, ns (docs/drive.md,
/// pin table).
const MONOSTABLE_NS: u64 = 2_000_000;
/// High: the high-voltage supply is on.
pub const HV_ENABLE: (Port, u8) = (Port::C, 8);
/// High: a fault is latched.
pub const FAULT_LAMP: (Port, u8) = (Port::C, 9);

/// Something done to the board at an instant.
pub type Act = Box<dyn FnOnce(&mut World, &mut ServoBoard, &mut dyn Host, VirtualNanos) + Send>;

/// A change at the outputs of the DAC.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandSeen {
    /// When.
    pub at: VirtualNanos,
    /// Codes on channels A and B.
    pub codes: [u16; 2],
    /// Torque at the motor's amplifier, N m.
    pub torque_nm: f64,
    /// Field at the high-voltage amplifier if its supply is on, kV/mm.
    pub field_kv_mm: f64,
    /// Whether the high-voltage supply is on.
    pub hv_enable: bool,
}

/// The world around the MCU.
pub struct World {
    /// The machine.
    pub rotor: Rotor,
    /// The user at the far end of the command link.
    pub link: LinkHost,
    /// In the place of that user, one behind a port of this machine.
    pub port: Option<TcpPort>,
    /// Ends the run before its time.
    pub ended: Arc<AtomicBool>,
    /// The sectors of flash that hold the parameters; they outlive the run.
    pub flash: Shared,
    /// Upsets the core.
    pub hand: Hand,
    /// The reader of the log; `None` when no probe is there.
    pub probe: Option<Probe>,
    /// Every write to the DAC's outputs, in order.
    pub commands: Vec<CommandSeen>,
    /// Instants of the falling edges of SAMPLE.
    pub samples: Vec<VirtualNanos>,
    /// Instants at which LDAC was low and the outputs of the DAC took what was written.
    pub loads: Vec<VirtualNanos>,
    /// Instants at which a tick had its commands ready and told LDAC to fall at its count.
    pub armed: Vec<VirtualNanos>,
    /// Edges of the heartbeat: ends of ticks.
    pub beats: Vec<VirtualNanos>,
    /// Angle of the rotor at each sample, rad.
    pub angles_rad: Vec<f64>,
    /// Instructions to watch; give them before the run.
    pub watch: Vec<u64>,
    /// Watched instructions that were reached, with the count of instructions before them.
    pub hits: Vec<(u64, u64)>,
    /// Instructions of each tick between its last input (the field monitor) and its first output (a pin of port C).
    pub law_instructions: Vec<u64>,
    last_input: Option<u64>,
    /// When the reset pin is pulled, if ever.
    pub reset_at: Option<VirtualNanos>,
    /// Field that a broken amplifier puts out whatever it is told, kV/mm.
    pub stray_field_kv_mm: f64,
    /// Last edge of the heartbeat.
    beat_at: VirtualNanos,
    /// The monostable has run out.
    released: bool,
    script: VecDeque<(VirtualNanos, Act)>,
    until: VirtualNanos,
    pins: Pins,
}

impl std::fmt::Debug for World {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("World").field("until", &self.until).field("pins", &self.pins).finish_non_exhaustive()
    }
}

/// Levels of the MCU's output pins, as last seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Pins {
    sample: bool,
    a0: bool,
    a1: bool,
    reset: bool,
    ldac: bool,
    clear: bool,
    hv_enable: bool,
    heartbeat: bool,
}

impl World {
    /// A world that ends at `until`, with nothing happening in it.
    pub fn new(rotor: Rotor, until: VirtualNanos) -> Self {
        Self {
            rotor,
            link: LinkHost::default(),
            port: None,
            ended: Arc::default(),
            flash: Shared::default(),
            hand: Hand::default(),
            probe: None,
            commands: Vec::new(),
            samples: Vec::new(),
            loads: Vec::new(),
            armed: Vec::new(),
            beats: Vec::new(),
            angles_rad: Vec::new(),
            watch: Vec::new(),
            hits: Vec::new(),
            law_instructions: Vec::new(),
            last_input: None,
            reset_at: None,
            stray_field_kv_mm: 0.0,
            beat_at: VirtualNanos(0),
            released: true,
            script: VecDeque::new(),
            until,
            // Pins float low until the image makes outputs of them; the board's pull-downs say the same.
            pins: Pins::default(),
        }
    }

    /// Does `act` at `at`; instants may come in any order.
    pub fn at(
        &mut self,
        at: VirtualNanos,
        act: impl FnOnce(&mut Self, &mut ServoBoard, &mut dyn Host, VirtualNanos) + Send + 'static,
    ) {
        let place = self.script.partition_point(|(when, _)| *when <= at);
        self.script.insert(place, (at, Box::new(act)));
    }

    /// What was seen so far, but for the outputs as they are.
    fn forget(&mut self) {
        let as_they_are = self.commands.pop();
        self.commands.clear();
        self.commands.extend(as_they_are);
        for instants in [&mut self.samples, &mut self.loads, &mut self.armed, &mut self.beats] {
            instants.clear();
        }
        self.angles_rad.clear();
        self.law_instructions.clear();
    }

    /// Drives a pin at an instant.
    pub fn drive_at(&mut self, at: VirtualNanos, (port, pin): (Port, u8), high: bool) {
        self.at(at, move |_, board, _, now| board.drive(now, port, pin, high));
    }

    /// Moves the rotor to `now`, and shows its angle to the converter and its field to the monitor.
    fn move_rotor(&mut self, board: &mut ServoBoard, now: VirtualNanos) {
        self.rotor.advance_to(now.0 as f64 * 1e-9);
        if let Some(resolver) = board.resolver() {
            resolver.advance_to(now);
            resolver.chip.set_motion(self.rotor.angle_rad(), self.rotor.speed_rad_s());
        }
        board.set_monitor(self.rotor.field_kv_mm() + self.stray_field_kv_mm);
    }

    /// Carries the levels of the MCU's pins to the chips.
    fn carry_pins(&mut self, board: &mut ServoBoard, now: VirtualNanos) {
        board.carry_timer(now);
        let pins = Pins {
            sample: board.level(Port::B, 0),
            a0: board.level(Port::B, 1),
            a1: board.level(Port::B, 2),
            reset: board.level(Port::B, 10),
            ldac: board.level(Port::C, 6),
            clear: board.level(Port::C, 7),
            hv_enable: board.level(Port::C, 8),
            heartbeat: board.level(HEARTBEAT.0, HEARTBEAT.1),
        };
        let before = std::mem::replace(&mut self.pins, pins);
        if pins == before {
            self.look_for_torn_pair(board, now);
            return;
        }
        if before.sample && !pins.sample {
            self.move_rotor(board, now);
            self.samples.push(now);
            self.angles_rad.push(self.rotor.angle_rad());
        }
        if let Some(resolver) = board.resolver() {
            resolver.advance_to(now);
            resolver.chip.set_pin(ResolverPin::A0, pins.a0);
            resolver.chip.set_pin(ResolverPin::A1, pins.a1);
            resolver.chip.set_pin(ResolverPin::Reset, pins.reset);
            resolver.chip.set_pin(ResolverPin::Sample, pins.sample);
        }
        let beats = before.heartbeat != pins.heartbeat;
        if beats {
            self.beats.push(now);
            self.beat_at = now;
        }
        if before.ldac && !pins.ldac {
            self.loads.push(now);
        }
        let starts = beats && std::mem::take(&mut self.released);
        let loads =
            starts || before.ldac && !pins.ldac || before.clear != pins.clear || before.hv_enable != pins.hv_enable;
        if let Some(dac) = board.dac() {
            dac.chip.set_pin(DacPin::Clear, pins.clear);
            dac.chip.set_pin(DacPin::Ldac, pins.ldac);
        }
        if loads {
            self.take_commands(board, now);
        }
    }

    /// Outputs that follow a single frame, as LDAC is low while it is written, act like any others.
    fn look_for_torn_pair(&mut self, board: &mut ServoBoard, now: VirtualNanos) {
        let before = self.commands.last().map_or([0, 0], |command| command.codes);
        if board.dac().is_some_and(|dac| dac.chip.codes() != before) {
            self.take_commands(board, now);
        }
    }

    /// The outputs of the DAC act on the rotor from `now` on.
    fn take_commands(&mut self, board: &mut ServoBoard, now: VirtualNanos) {
        let Some(dac) = board.dac() else { return };
        let hv_enable = self.pins.hv_enable && !self.released;
        let (codes, torque_nm) = (dac.chip.codes(), if self.released { 0.0 } else { dac.chip.torque_nm() });
        let field_kv_mm = if hv_enable { dac.chip.field_kv_mm() } else { 0.0 };
        self.rotor.advance_to(now.0 as f64 * 1e-9);
        self.rotor.command(torque_nm, field_kv_mm);
        self.commands.push(CommandSeen { at: now, codes, torque_nm, field_kv_mm, hv_enable });
    }
}

impl Driver<ServoBoard> for World {
    fn on_settled(&mut self, session: &mut Session<ServoBoard>, _host: &mut dyn Host, settled: Settled) {
        match settled {
            Settled::Access { access, .. } if access.kind == AccessKind::Write => {
                if ADC1.contains(&access.address) {
                    self.last_input = Some(access.instruction_count);
                }
                if access.address == TIM3_CCMR1 && access.value == FALLS_AT_MATCH {
                    self.armed.push(access.virtual_time);
                }
                if PORTS.contains(&access.address) || TIM3.contains(&access.address) {
                    if access.address >= PORT_C
                        && let Some(input) = self.last_input.take()
                    {
                        self.law_instructions.push(access.instruction_count - input);
                    }
                    self.carry_pins(session.board_mut(), access.virtual_time);
                }
            }
            // The timer moves its pins without the core.
            Settled::Stop(stop) => self.carry_pins(session.board_mut(), stop.at),
            Settled::Hit(hit) => self.hits.push((hit.address, hit.instruction_count)),
            _ => {}
        }
    }

    fn on_stop(&mut self, session: &mut Session<ServoBoard>, stop: Stop, host: &mut dyn Host) -> Option<VirtualNanos> {
        let now = stop.at;
        for address in self.watch.drain(..) {
            session.watch(Watch::Instruction(address));
        }
        session.settle_watches(host);
        while self.script.front().is_some_and(|(when, _)| *when <= now) {
            if let Some((_, act)) = self.script.pop_front() {
                act(self, session.board_mut(), host, now);
            }
        }
        if self.reset_at.is_some_and(|at| at <= now) {
            self.reset_at = None;
            session.reset_by_pin(now, stop.instruction_count, host);
        }
        self.carry_pins(session.board_mut(), now);
        if !self.released && now.0 > self.beat_at.0 + MONOSTABLE_NS {
            self.released = true;
            self.take_commands(session.board_mut(), now);
        }
        if let Some(terminal) = session.board_mut().terminal() {
            match &mut self.port {
                Some(port) => port.attend(terminal, now),
                None => self.link.attend(terminal, now),
            }
        }
        if self.port.is_some() && self.samples.len() > KEPT_TICKS {
            self.forget();
        }
        if let Some(probe) = &mut self.probe {
            probe.drain(host);
        }
        if now >= self.until || self.ended.load(Ordering::Relaxed) {
            return None;
        }
        // A byte that is due and not taken (the receiver is off) is offered again a byte's time later.
        let due = session.board_mut().terminal().and_then(|terminal| terminal.next_due());
        let due = due.map(|due| if due > now { due } else { VirtualNanos(now.0 + BYTE_NS) });
        let script = self.script.front().map(|(when, _)| *when);
        let next = [Some(VirtualNanos(now.0 + STRIDE_NS)), due, script, self.reset_at, Some(self.until)]
            .into_iter()
            .flatten()
            .min();
        next.map(|next| VirtualNanos(next.0.max(now.0 + 1)))
    }
}
