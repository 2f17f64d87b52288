//! AD2S1210 resolver-to-digital converter behind a 120-pole-pair resolver.

use std::f64::consts::TAU;

use super::{BusFault, Chip, Line};

/// Pole pairs of the resolver.
pub const POLE_PAIRS: u32 = 120;
/// Counts of the 12-bit mode in one mechanical revolution.
pub const COUNTS_PER_REV: u32 = POLE_PAIRS * 4096;
/// Speed above which the 12-bit mode no longer tracks, electrical rev/s, at CLKIN 8.192 MHz.
const TRACKING_LIMIT_REV_S: f64 = 1000.0;
/// Time from a reset to valid position for resolutions 00, 01, 10, 11 (10, 12, 14, 16 bit), s.
const SETTLE_S: [f64; 4] = [0.010, 0.020, 0.025, 0.060];
/// From the falling edge of SAMPLE until what it latched can be read, s: 6 periods of 8.192 MHz and 20 ns.
const LATCH_S: f64 = 752.4e-9;
/// RESET must be low this long to act, s.
const RESET_WIDTH_S: f64 = 10e-6;

const FAULT_PARITY: u8 = 0x01;
const FAULT_OVER_SPEED: u8 = 0x04;
/// What the signal monitors say while the loop settles: loss of tracking and phase.
const FAULTS_SETTLING: u8 = 0x0A;

const REGISTER_COUNT: usize = 9;
/// Addresses of the writable registers, and the values they hold after a reset.
const REGISTERS: [(u8, u8); REGISTER_COUNT] =
    [(0x88, 58), (0x89, 108), (0x8A, 10), (0x8B, 60), (0x8C, 105), (0x8D, 89), (0x8E, 36), (0x91, 40), (0x92, 0x7E)];
const CONTROL: usize = 8;

/// Pins the MCU drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pin {
    /// Falling edge latches position and faults.
    Sample,
    /// With [`Pin::A1`]: 00 position, 01 velocity, 11 configuration.
    A0,
    /// See [`Pin::A0`].
    A1,
    /// Active low.
    Reset,
}

/// Where the serial port is in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Port {
    /// No select.
    Idle,
    /// So many bytes of a position or velocity frame are out.
    Frame(u8),
    /// One byte of configuration traffic.
    Configuration,
}

/// The chip.
#[derive(Debug, Clone)]
pub struct Ad2s1210 {
    // What the resolver does.
    angle_rad: f64,
    speed_rad_s: f64,
    // Pins and port.
    sample: bool,
    a0: bool,
    a1: bool,
    reset: bool,
    port: Port,
    wedged: bool,
    address: Option<u8>,
    answer: u8,
    // Registers.
    registers: [u8; REGISTER_COUNT],
    parity_bad: [bool; REGISTER_COUNT],
    faults: u8,
    latched: [u8; 3],
    latched_velocity: u16,
    /// What a read gives as long as the latch before is too young.
    stale: [u8; 3],
    since_latch_s: f64,
    settle_s: f64,
    reset_low_s: f64,
    // Faults put in.
    line: Line,
    raised: u8,
    frozen: Option<u16>,
    jump_counts: i32,
}

impl Default for Ad2s1210 {
    fn default() -> Self {
        Self::new()
    }
}

impl Ad2s1210 {
    /// The chip as it comes up: SAMPLE and RESET high, position mode, not settled.
    pub fn new() -> Self {
        let mut chip = Self {
            angle_rad: 0.0,
            speed_rad_s: 0.0,
            sample: true,
            a0: false,
            a1: false,
            reset: true,
            port: Port::Idle,
            wedged: false,
            address: None,
            answer: 0,
            registers: [0; REGISTER_COUNT],
            parity_bad: [false; REGISTER_COUNT],
            faults: 0,
            latched: [0; 3],
            latched_velocity: 0,
            stale: [0; 3],
            since_latch_s: f64::INFINITY,
            settle_s: 0.0,
            reset_low_s: 0.0,
            line: Line::new(),
            raised: 0,
            frozen: None,
            jump_counts: 0,
        };
        chip.restart();
        chip
    }

    /// The rotor is at `angle_rad` (mechanical, any number of turns) and moves at `speed_rad_s`.
    pub fn set_motion(&mut self, angle_rad: f64, speed_rad_s: f64) {
        self.angle_rad = angle_rad;
        self.speed_rad_s = speed_rad_s;
    }

    /// Whole counts of the rotor's angle, across pole pairs; what a perfect converter would have counted.
    pub fn true_counts(&self) -> i64 {
        (self.angle_rad / TAU * f64::from(COUNTS_PER_REV)).floor() as i64
    }

    /// Puts a fault on the data line; `seed` is for [`BusFault::Garbage`].
    pub fn set_bus_fault(&mut self, fault: BusFault, seed: u64) {
        self.line.set(fault, seed);
    }

    /// Raises conditions of the fault register, a bit each, for as long as they are set here.
    pub fn raise_faults(&mut self, bits: u8) {
        self.raised = bits;
    }

    /// Freezes the position that is latched, or lets it go.
    pub fn freeze(&mut self, frozen: bool) {
        self.frozen = frozen.then(|| self.counts_in_pole_pair());
    }

    /// Shifts the position by so many counts from here on, as a slip of the tracking loop does.
    pub fn jump(&mut self, counts: i32) {
        self.jump_counts = counts;
    }

    /// Spoils the register at `address` (a bit flips in the chip, its parity no longer fits). Unknown addresses do nothing.
    pub fn corrupt_register(&mut self, address: u8, flip: u8) {
        if let Some(at) = index_of(address) {
            self.registers[at] ^= flip & 0x7F;
            self.parity_bad[at] = true;
        }
    }

    /// Whether a byte 0x00 in configuration mode has hung the port; only RESET frees it.
    pub fn is_wedged(&self) -> bool {
        self.wedged
    }

    /// What the register at `address` holds, without the parity bit.
    pub fn register(&self, address: u8) -> Option<u8> {
        index_of(address).map(|at| self.registers[at])
    }

    fn restart(&mut self) {
        self.registers = REGISTERS.map(|(_, value)| value);
        self.parity_bad = [false; REGISTER_COUNT];
        self.wedged = false;
        self.address = None;
        self.answer = 0;
        self.faults = 0;
        self.settle();
    }

    fn settle(&mut self) {
        self.settle_s = SETTLE_S[usize::from(self.registers[CONTROL] & 0b11)];
    }

    fn counts_in_pole_pair(&self) -> u16 {
        ((self.true_counts() + i64::from(self.jump_counts)).rem_euclid(4096)) as u16
    }

    /// Conditions of the moment. The fault register collects them until it is read.
    fn conditions(&self) -> u8 {
        let mut bits = self.raised;
        if self.settle_s > 0.0 {
            bits |= FAULTS_SETTLING;
        }
        if self.electrical_rev_s().abs() > TRACKING_LIMIT_REV_S {
            bits |= FAULT_OVER_SPEED;
        }
        if self.parity_bad.contains(&true) {
            bits |= FAULT_PARITY;
        }
        bits
    }

    fn electrical_rev_s(&self) -> f64 {
        self.speed_rad_s * f64::from(POLE_PAIRS) / TAU
    }

    fn latch(&mut self) {
        self.stale = self.readable();
        self.since_latch_s = 0.0;
        self.faults |= self.conditions();
        // The resolution of the position frame is that of the RES pins, tied to 12 bit on this board.
        let counts = if self.settle_s > 0.0 { 0 } else { self.frozen.unwrap_or_else(|| self.counts_in_pole_pair()) };
        let [high, low] = (counts << 4).to_be_bytes();
        self.latched = [high, low, self.faults];
        let velocity = (self.electrical_rev_s() / TRACKING_LIMIT_REV_S * 2048.0).clamp(-2048.0, 2047.0) as i16;
        self.latched_velocity = (velocity << 4).cast_unsigned();
    }

    /// What the port gives now: the last latch, or the one before while it is too young.
    fn readable(&self) -> [u8; 3] {
        // Half a nanosecond for the rounding of the clock that counts it.
        if self.since_latch_s >= LATCH_S - 0.5e-9 { self.latched } else { self.stale }
    }

    /// One byte in configuration mode; gives the answer to the byte before.
    fn configure(&mut self, byte: u8) -> u8 {
        let answer = std::mem::take(&mut self.answer);
        if byte == 0x00 {
            self.wedged = true;
        } else if byte & 0x80 != 0 {
            self.address = Some(byte);
            self.answer = self.look_up(byte);
        } else if let Some(address) = self.address.take() {
            // What was written is also what the part echoes next.
            self.answer = byte;
            match index_of(address) {
                Some(at) => {
                    self.registers[at] = byte;
                    self.parity_bad[at] = false;
                }
                None if address == 0xF0 => self.settle(),
                None => {}
            }
        }
        answer
    }

    fn look_up(&mut self, address: u8) -> u8 {
        let velocity = self.latched_velocity.to_be_bytes();
        match address {
            0x80 => self.latched[0],
            0x81 => self.latched[1],
            0x82 => velocity[0],
            0x83 => velocity[1],
            0xFF => std::mem::take(&mut self.faults),
            _ => index_of(address).map_or(0, |at| self.registers[at] | u8::from(self.parity_bad[at]) << 7),
        }
    }
}

fn index_of(address: u8) -> Option<usize> {
    REGISTERS.iter().position(|(known, _)| *known == address)
}

impl Chip for Ad2s1210 {
    type Pin = Pin;

    fn select(&mut self) {
        self.port = match (self.a1, self.a0) {
            (true, true) => Port::Configuration,
            _ => Port::Frame(0),
        };
    }

    fn transfer(&mut self, mosi: u8) -> u8 {
        let dead = self.wedged || !self.reset;
        let answer = match self.port {
            Port::Idle => 0,
            _ if dead => 0,
            Port::Configuration => {
                // One byte a frame: a second one in the same frame is not clocked in.
                self.port = Port::Idle;
                self.configure(mosi)
            }
            Port::Frame(at) => {
                self.port = Port::Frame(at.saturating_add(1));
                let velocity = self.latched_velocity.to_be_bytes();
                let latched = self.readable();
                let frame = if self.a0 { [velocity[0], velocity[1], latched[2]] } else { latched };
                frame.get(usize::from(at)).copied().unwrap_or(0)
            }
        };
        self.line.carry(answer)
    }

    fn deselect(&mut self) {
        self.port = Port::Idle;
    }

    fn set_pin(&mut self, pin: Pin, high: bool) {
        match pin {
            Pin::Sample => {
                if self.sample && !high {
                    self.latch();
                }
                self.sample = high;
            }
            Pin::A0 => self.a0 = high,
            Pin::A1 => self.a1 = high,
            Pin::Reset => {
                if high && !self.reset && self.reset_low_s >= RESET_WIDTH_S {
                    self.restart();
                }
                self.reset = high;
                self.reset_low_s = 0.0;
            }
        }
    }

    fn advance(&mut self, dt_s: f64) {
        self.since_latch_s += dt_s;
        if self.reset {
            self.settle_s = (self.settle_s - dt_s).max(0.0);
        } else {
            self.reset_low_s += dt_s;
        }
    }
}
