//! AD5754R / AD5752R digital-to-analogue converter, with the amplifiers behind it.

use super::{BusFault, Chip, Line};

/// N m at the motor for a volt on channel A.
pub const TORQUE_NM_PER_V: f64 = 3.0;
/// kV/mm in the gap for a volt on channel B: 0.2 kV over 0.5 mm.
pub const FIELD_KV_MM_PER_V: f64 = 0.4;

/// Which part; they differ in the address of channel B and in the power register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// AD5754R.
    Quad,
    /// AD5752R.
    Dual,
}

/// Pins the MCU drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pin {
    /// Low transfers what was written to the outputs.
    Ldac,
    /// Low clears codes and outputs.
    Clear,
}

/// Span of an output, V.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Range {
    low_v: f64,
    span_v: f64,
}

/// Spans by the code of the range register, at the internal reference of 2.5 V.
const RANGES: [Range; 6] = [
    Range { low_v: 0.0, span_v: 5.0 },
    Range { low_v: 0.0, span_v: 10.0 },
    Range { low_v: 0.0, span_v: 10.8 },
    Range { low_v: -5.0, span_v: 10.0 },
    Range { low_v: -10.0, span_v: 20.0 },
    Range { low_v: -10.8, span_v: 21.6 },
];

#[derive(Debug, Clone, Copy, Default)]
struct Channel {
    range: u16,
    /// Written.
    input: u16,
    /// At the output.
    output: u16,
}

impl Channel {
    fn volts(self) -> f64 {
        let Some(range) = RANGES.get(usize::from(self.range)) else { return 0.0 };
        if range.low_v < 0.0 {
            // BIN/2sCOMP is tied low: two's complement in the bipolar ranges.
            f64::from(self.output.cast_signed()) / 65_536.0 * range.span_v
        } else {
            f64::from(self.output) / 65_536.0 * range.span_v
        }
    }
}

const CONTROL_DEFAULT: u16 = 0b0100;
const THERMAL_ENABLE: u16 = 0b1000;
const POWER_REFERENCE: u16 = 1 << 4;
const POWER_SHUTDOWN: u16 = 1 << 5;

/// The chip.
#[derive(Debug, Clone)]
pub struct Dac {
    part: Part,
    a: Channel,
    b: Channel,
    control: u16,
    power: u16,
    ldac: bool,
    clear: bool,
    selected: bool,
    shift: [u8; 3],
    bits_in: usize,
    answer: [u8; 3],
    // Faults put in.
    line: Line,
    over_current: [bool; 2],
    overheated: bool,
    deaf: bool,
}

impl Dac {
    /// The chip after power-up: outputs off, codes 0, range 0..5 V.
    pub fn new(part: Part) -> Self {
        Self {
            part,
            a: Channel::default(),
            b: Channel::default(),
            control: CONTROL_DEFAULT,
            power: 0,
            ldac: true,
            clear: true,
            selected: false,
            shift: [0; 3],
            bits_in: 0,
            answer: [0; 3],
            line: Line::new(),
            over_current: [false; 2],
            overheated: false,
            deaf: false,
        }
    }

    /// Volts on the channels A and B; 0 while a channel is powered down or cleared.
    pub fn volts(&self) -> [f64; 2] {
        let reference = self.power & POWER_REFERENCE != 0;
        let on = |bit: u16| reference && self.power & 1 << bit != 0;
        [if on(0) { self.a.volts() } else { 0.0 }, if on(self.address_b().into()) { self.b.volts() } else { 0.0 }]
    }

    /// Torque command at the motor's amplifier, N m.
    pub fn torque_nm(&self) -> f64 {
        self.volts()[0] * TORQUE_NM_PER_V
    }

    /// Field command at the high-voltage amplifier, kV/mm; it cannot go below zero.
    pub fn field_kv_mm(&self) -> f64 {
        (self.volts()[1] * FIELD_KV_MM_PER_V).max(0.0)
    }

    /// The codes at the outputs of A and B.
    pub fn codes(&self) -> [u16; 2] {
        [self.a.output, self.b.output]
    }

    /// Puts a fault on the data line; `seed` is for [`BusFault::Garbage`].
    pub fn set_bus_fault(&mut self, fault: BusFault, seed: u64) {
        self.line.set(fault, seed);
    }

    /// Loads the outputs A and B beyond their current limit, or not.
    pub fn overload(&mut self, channels: [bool; 2]) {
        self.over_current = channels;
    }

    /// Takes the die over 150 degrees C: with thermal shutdown enabled the outputs power down.
    pub fn overheat(&mut self, hot: bool) {
        self.overheated = hot;
        if hot && self.control & THERMAL_ENABLE != 0 {
            self.power &= POWER_REFERENCE;
        }
    }

    /// The chip no longer takes what is written to it (its select line is broken); its outputs stay.
    pub fn deafen(&mut self, deaf: bool) {
        self.deaf = deaf;
    }

    fn address_b(&self) -> u8 {
        match self.part {
            Part::Quad => 1,
            Part::Dual => 2,
        }
    }

    fn channels(&mut self, address: u8) -> [Option<&mut Channel>; 2] {
        let b = self.address_b();
        match address {
            0 => [Some(&mut self.a), None],
            4 => [Some(&mut self.a), Some(&mut self.b)],
            _ if address == b => [None, Some(&mut self.b)],
            _ => [None, None],
        }
    }

    fn each(&mut self, address: u8, act: impl Fn(&mut Channel)) {
        self.channels(address).into_iter().flatten().for_each(act);
    }

    fn first(&mut self, address: u8) -> Channel {
        self.channels(address).into_iter().flatten().next().copied().unwrap_or_default()
    }

    fn load(&mut self) {
        if self.clear {
            self.each(4, |channel| channel.output = channel.input);
        }
    }

    fn clear_outputs(&mut self) {
        self.each(4, |channel| {
            channel.input = 0;
            channel.output = 0;
        });
    }

    fn power_register(&self) -> u16 {
        let hot = self.overheated && self.control & THERMAL_ENABLE != 0;
        let current = |channel: usize, bit: u8| u16::from(self.over_current[channel]) << bit;
        self.power | if hot { POWER_SHUTDOWN } else { 0 } | current(0, 7) | current(1, 7 + self.address_b())
    }

    fn execute(&mut self) {
        let [command, high, low] = self.shift;
        let data = u16::from_be_bytes([high, low]);
        let (register, address) = (command >> 3 & 0b111, command & 0b111);
        if command & 0x80 != 0 {
            self.read_back(command, register, address);
            return;
        }
        match (register, address) {
            (0, _) => self.each(address, |channel| channel.input = data),
            (1, _) => self.each(address, |channel| channel.range = data & 0b111),
            (2, _) => self.power = data & 0b1_1111,
            (3, 1) => self.control = data & 0b1111,
            (3, 4) => self.clear_outputs(),
            (3, 5) => self.load(),
            // No operation.
            _ => {}
        }
        if !self.ldac {
            self.load();
        }
    }

    fn read_back(&mut self, command: u8, register: u8, address: u8) {
        let data = match (register, address) {
            (0, _) => self.first(address).output,
            (1, _) => self.first(address).range,
            (2, _) => self.power_register(),
            (3, 1) => self.control,
            _ => 0,
        };
        let [high, low] = data.to_be_bytes();
        self.answer = [command, high, low];
    }
}

impl Chip for Dac {
    type Pin = Pin;

    fn select(&mut self) {
        self.selected = true;
        self.bits_in = 0;
    }

    fn transfer(&mut self, mosi: u8) -> u8 {
        let at = self.bits_in / 8;
        self.bits_in += 8;
        if let Some(byte) = self.shift.get_mut(at) {
            *byte = mosi;
        }
        let sdo_on = self.control & 1 == 0;
        let answer = if self.selected && sdo_on { self.answer.get(at).copied().unwrap_or(0) } else { 0 };
        self.line.carry(answer)
    }

    fn deselect(&mut self) {
        // A frame of another length is ignored: SYNC has to rise after the 24th clock.
        if std::mem::take(&mut self.selected) && self.bits_in == 24 && !self.deaf {
            self.answer = [0; 3];
            self.execute();
        }
    }

    fn set_pin(&mut self, pin: Pin, high: bool) {
        match pin {
            Pin::Ldac => {
                self.ldac = high;
                if !high {
                    self.load();
                }
            }
            Pin::Clear => {
                self.clear = high;
                if !high {
                    self.clear_outputs();
                }
            }
        }
    }

    fn advance(&mut self, _dt_s: f64) {}
}
