//! AD2S1210 resolver-to-digital converter, serial interface, 12-bit resolution.
//!
//! # How the part is spoken to
//!
//! Pins A1 A0 choose what the serial port carries: 00 position, 11 configuration. In position mode one frame of 24 bits
//! gives 16 bits of position, left-justified, and the fault register. In configuration mode every byte is a frame of its
//! own: a byte with the top bit set is an address, one without is data for the last address, and the answer to an address
//! arrives during the *next* byte. That next byte must again be a valid address, as 0x00 would be taken for data and
//! wedges the port; so this driver never sends 0x00 in configuration mode.
//!
//! A register that is read back with its top bit set has lost its parity: the part's own check of its configuration
//! (the bit D0 of the fault register says the same of all of them together).
//!
//! # Wiring this driver relies on
//!
//! SPI mode 1, at most 25 MHz; RES1 RES0 tied to 01 (12 bit in position mode, the control register says the same for
//! configuration mode); SOE low (serial port); CS tied low and the SPI select on WR/FSYNC.
//!
//! # Timing of a tick
//!
//! [`Ad2s1210::latch`] drops SAMPLE and [`Ad2s1210::read`] clocks out what was latched. Between the two the part needs
//! 6 t_CK + 20 ns, 753 ns at 8.192 MHz: read sooner it gives what was latched before. Neither call waits: the caller puts work between them, as the image does
//! with its pins and its ADC.
//!
//! # Sources
//!
//! Data sheet AD2S1210, held against the Linux driver `drivers/iio/resolver/ad2s1210.c`, which agrees in the addresses,
//! the bits of the fault and the control register, 38 mV a count of the thresholds, the settling time of 20 ms at 12 bit
//! after a reset, the fault register that must be read after it, and parity in the top bit. The thresholds'
//! reset values are the data sheet's.

mod faults;

use core::fmt;

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::{Operation, SpiDevice};
pub use faults::Faults;

/// SAMPLE low to the first clock of the read, ns: 6 t_CK + 20 ns at a CLKIN of 8.192 MHz (board.md).
pub const SAMPLE_TO_READ_NS: u32 = 753;

/// Width of the RESET pulse, us; the datasheet asks for 10.
const RESET_PULSE_US: u32 = 20;
/// Tracking loop settled after a reset at 12 bit, ms (datasheet t_TRACK), with CLKIN at 8.192 MHz.
const SETTLE_MS: u32 = 20;
/// RESET released to the first access of the serial port, ms.
const WAKE_MS: u32 = 1;

/// A configuration register that is written by this driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Register {
    /// Loss of signal threshold, 38 mV a count.
    LossOfSignal = 0x88,
    /// Degradation of signal, overrange threshold, 38 mV a count.
    Overrange = 0x89,
    /// Degradation of signal, mismatch threshold, 38 mV a count.
    Mismatch = 0x8A,
    /// Degradation of signal, reset maximum, 38 mV a count.
    ResetMax = 0x8B,
    /// Degradation of signal, reset minimum, 38 mV a count.
    ResetMin = 0x8C,
    /// Loss of tracking, high threshold, 0.14 degree a count at 12 bit.
    TrackingHigh = 0x8D,
    /// Loss of tracking, low threshold, 0.14 degree a count at 12 bit.
    TrackingLow = 0x8E,
    /// Excitation frequency word, CLKIN / 2^15 a count (250 Hz at 8.192 MHz).
    Excitation = 0x91,
    /// Resolution, hysteresis and phase lock range.
    Control = 0x92,
}

const SOFT_RESET: u8 = 0xF0;
const FAULT: u8 = 0xFF;
/// Marks a byte as an address; on a register read back, a parity error.
const TOP_BIT: u8 = 0x80;
/// D5 phase lock range 44 degrees, D4 hysteresis on, D3:2 encoder outputs 16 bit, D1:0 = 01 resolution 12 bit.
const CONTROL_12_BIT: u8 = 0x7D;

/// What went wrong in talking to the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Error<E> {
    /// The SPI bus reported an error.
    Bus(E),
    /// SAMPLE, A0, A1 or RESET could not be driven.
    Pin,
    /// A register does not hold what was written to it.
    ReadBack {
        /// The register.
        register: Register,
        /// What was written.
        wrote: u8,
        /// What came back.
        read: u8,
    },
    /// A register came back with its parity bit set.
    Parity {
        /// The register.
        register: Register,
    },
    /// A setting does not fit its register.
    Setting {
        /// The register.
        register: Register,
        /// The value asked for; allowed is 1 to 127, and 8 to 80 for the excitation.
        value: u8,
    },
    /// Faults that are still there once the tracking loop has settled and the register was cleared.
    Faulty(Faults),
}

impl<E: fmt::Debug> fmt::Display for Error<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bus(e) => write!(f, "resolver converter: SPI error {e:?}"),
            Self::Pin => write!(f, "resolver converter: a control pin could not be driven"),
            Self::ReadBack { register, wrote, read } => write!(
                f,
                "resolver converter: register {register:?} holds {read:#04x} after {wrote:#04x} was written; check its SPI wiring and supply"
            ),
            Self::Parity { register } => write!(f, "resolver converter: parity error in register {register:?}"),
            Self::Setting { register, value } => {
                write!(f, "resolver converter: {value} does not fit register {register:?}")
            }
            Self::Faulty(faults) => {
                write!(f, "resolver converter:")?;
                faults.sentences().try_for_each(|sentence| write!(f, " {sentence};"))
            }
        }
    }
}

/// Thresholds and excitation, in the units of the registers; see [`Register`] for what a count is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Loss of signal below this amplitude, 38 mV a count.
    pub loss_of_signal: u8,
    /// Overrange above this amplitude, 38 mV a count.
    pub overrange: u8,
    /// Mismatch above this difference of amplitudes, 38 mV a count.
    pub mismatch: u8,
    /// Start value of the maximum search of the mismatch monitor, 38 mV a count.
    pub reset_max: u8,
    /// Start value of the minimum search of the mismatch monitor, 38 mV a count.
    pub reset_min: u8,
    /// Tracking is lost above this error, 0.14 degree a count.
    pub tracking_high: u8,
    /// Tracking is found again below this error, 0.14 degree a count.
    pub tracking_low: u8,
    /// Excitation frequency, 250 Hz a count at 8.192 MHz, 8 to 80 (2 to 20 kHz).
    pub excitation: u8,
}

impl Default for Settings {
    /// 2.2 V, 4.1 V, 0.38 V, 2.28 V, 3.99 V, 12.5 and 5 degrees, 10 kHz: the defaults the datasheet gives the registers.
    fn default() -> Self {
        Self {
            loss_of_signal: 58,
            overrange: 108,
            mismatch: 10,
            reset_max: 60,
            reset_min: 105,
            tracking_high: 89,
            tracking_low: 36,
            excitation: 40,
        }
    }
}

impl Settings {
    fn registers(&self) -> [(Register, u8); 9] {
        [
            (Register::Control, CONTROL_12_BIT),
            (Register::LossOfSignal, self.loss_of_signal),
            (Register::Overrange, self.overrange),
            (Register::Mismatch, self.mismatch),
            (Register::ResetMax, self.reset_max),
            (Register::ResetMin, self.reset_min),
            (Register::TrackingHigh, self.tracking_high),
            (Register::TrackingLow, self.tracking_low),
            (Register::Excitation, self.excitation),
        ]
    }
}

/// One latched position and what the part says about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reading {
    /// Position within the pole pair, 0 to 4095.
    pub counts: u16,
    /// Fault register at the moment of the latch.
    pub faults: Faults,
}

/// The pins beside the SPI port.
#[derive(Debug)]
pub struct Pins<Sample, A0, A1, Reset> {
    /// SAMPLE; its falling edge latches.
    pub sample: Sample,
    /// A0.
    pub a0: A0,
    /// A1.
    pub a1: A1,
    /// RESET, active low.
    pub reset: Reset,
}

/// The converter on its SPI bus.
#[derive(Debug)]
pub struct Ad2s1210<Spi, Sample, A0, A1, Reset> {
    spi: Spi,
    pins: Pins<Sample, A0, A1, Reset>,
}

impl<Spi, Sample, A0, A1, Reset> Ad2s1210<Spi, Sample, A0, A1, Reset>
where
    Spi: SpiDevice,
    Sample: OutputPin,
    A0: OutputPin,
    A1: OutputPin,
    Reset: OutputPin,
{
    /// Takes the port and the pins; nothing is sent before [`Self::init`].
    pub fn new(spi: Spi, pins: Pins<Sample, A0, A1, Reset>) -> Self {
        Self { spi, pins }
    }

    /// Resets the part, writes every setting and reads it back, waits for the tracking loop, clears what faults the
    /// reset itself raised, and leaves the part in position mode. Takes about 42 ms.
    ///
    /// # Errors
    ///
    /// Whatever the bus or the part answers; [`Error::Faulty`] when faults remain once everything has settled.
    pub fn init(&mut self, settings: &Settings, delay: &mut impl DelayNs) -> Result<(), Error<Spi::Error>> {
        drive(self.pins.sample.set_high())?;
        drive(self.pins.reset.set_low())?;
        delay.delay_us(RESET_PULSE_US);
        drive(self.pins.reset.set_high())?;
        delay.delay_ms(WAKE_MS);

        self.configuration_mode()?;
        for (register, value) in settings.registers() {
            self.write_verified(register, value)?;
        }
        // The excitation generator takes up a new frequency on a soft reset; that keeps the other registers. The data
        // byte is ignored by the part, but must not be 0x00.
        self.byte(SOFT_RESET)?;
        self.byte(0x01)?;
        delay.delay_ms(SETTLE_MS);
        // First clear drops what the resets raised; a fault seen in the latch after it is a real one.
        self.clear_faults(delay)?;
        delay.delay_us(RESET_PULSE_US);
        self.latch()?;
        delay.delay_ns(SAMPLE_TO_READ_NS);
        let reading = self.read()?;
        if reading.faults.is_empty() { Ok(()) } else { Err(Error::Faulty(reading.faults)) }
    }

    /// Clears the fault register by reading it, and gives what it held. Leaves the part in position mode. Takes a few
    /// microseconds, so for thread mode.
    ///
    /// # Errors
    ///
    /// Bus and pin errors.
    pub fn clear_faults(&mut self, delay: &mut impl DelayNs) -> Result<Faults, Error<Spi::Error>> {
        self.latch()?;
        delay.delay_ns(SAMPLE_TO_READ_NS);
        self.configuration_mode()?;
        let held = self.register(FAULT)?;
        drive(self.pins.sample.set_high())?;
        delay.delay_ns(SAMPLE_TO_READ_NS);
        self.position_mode()?;
        Ok(Faults::from_bits_retain(held))
    }

    /// Reads a configuration register and checks its parity. Leaves the part in position mode.
    ///
    /// # Errors
    ///
    /// Bus and pin errors; [`Error::Parity`].
    pub fn read_register(&mut self, register: Register) -> Result<u8, Error<Spi::Error>> {
        self.configuration_mode()?;
        let value = self.checked(register);
        self.position_mode()?;
        value
    }

    /// Latches position and faults: SAMPLE falls. Leave [`SAMPLE_TO_READ_NS`] before [`Self::read`].
    ///
    /// # Errors
    ///
    /// [`Error::Pin`].
    pub fn latch(&mut self) -> Result<(), Error<Spi::Error>> {
        drive(self.pins.sample.set_low())
    }

    /// Clocks out what [`Self::latch`] latched and raises SAMPLE again. 24 clocks; no waiting beside them.
    ///
    /// A bus that is stuck low reads as position 0 without faults: only the caller, who knows the position before, can
    /// tell (jump and stale detection of the control library).
    ///
    /// # Errors
    ///
    /// Bus and pin errors.
    pub fn read(&mut self) -> Result<Reading, Error<Spi::Error>> {
        let mut frame = [0; 3];
        let answer = self.spi.read(&mut frame);
        drive(self.pins.sample.set_high())?;
        answer.map_err(Error::Bus)?;
        let [high, low, faults] = frame;
        Ok(Reading { counts: u16::from_be_bytes([high, low]) >> 4, faults: Faults::from_bits_retain(faults) })
    }

    /// Gives port and pins back.
    pub fn release(self) -> (Spi, Pins<Sample, A0, A1, Reset>) {
        (self.spi, self.pins)
    }

    fn write_verified(&mut self, register: Register, value: u8) -> Result<(), Error<Spi::Error>> {
        let allowed = if register == Register::Excitation { 8..=80 } else { 1..=127 };
        if !allowed.contains(&value) {
            return Err(Error::Setting { register, value });
        }
        self.byte(register as u8)?;
        self.byte(value)?;
        let read = self.checked(register)?;
        if read == value { Ok(()) } else { Err(Error::ReadBack { register, wrote: value, read }) }
    }

    fn checked(&mut self, register: Register) -> Result<u8, Error<Spi::Error>> {
        let value = self.register(register as u8)?;
        if value & TOP_BIT == 0 { Ok(value) } else { Err(Error::Parity { register }) }
    }

    /// The two frames of a register read. The second byte is the address of a register whose reading has no effect.
    fn register(&mut self, address: u8) -> Result<u8, Error<Spi::Error>> {
        self.byte(address)?;
        self.byte(Register::Control as u8)
    }

    /// One byte, framed on its own.
    fn byte(&mut self, byte: u8) -> Result<u8, Error<Spi::Error>> {
        let mut word = [byte];
        self.spi.transaction(&mut [Operation::TransferInPlace(&mut word)]).map_err(Error::Bus)?;
        Ok(word[0])
    }

    fn configuration_mode(&mut self) -> Result<(), Error<Spi::Error>> {
        drive(self.pins.a0.set_high())?;
        drive(self.pins.a1.set_high())
    }

    fn position_mode(&mut self) -> Result<(), Error<Spi::Error>> {
        drive(self.pins.a0.set_low())?;
        drive(self.pins.a1.set_low())
    }
}

fn drive<P, E>(result: Result<(), P>) -> Result<(), Error<E>> {
    result.map_err(|_| Error::Pin)
}
