//! AD5754R / AD5752R digital-to-analogue converter: channel A commands the torque, channel B the field.
//!
//! A driver of our own, as the crate `ad57xx` 0.3 does not serve: its readback joins the first and second byte of the
//! answer instead of the second and third, so no register can be verified; the over-current and thermal bits of its power
//! register and the thermal-shutdown enable are private; its power word never sets the internal reference's bit; and it
//! has neither the LDAC nor the CLR pin.
//!
//! # Wiring this driver relies on
//!
//! SPI mode 1, at most 15 MHz (readback); BIN/2sCOMP tied low, so that code 0 is 0 V in a bipolar range too and neither
//! power-up nor a clear can command torque; LDAC and CLR on pins. LDAC low transfers both channels together. CLR low
//! forces both outputs to 0 V without the bus: what a fault handler can still do when nothing else works.
//!
//! # Sources
//!
//! Data sheet AD5724R/AD5734R/AD5754R: tables of the input shift register, of the control functions and of the power
//! control register (PU A to D in bits 0 to 3, the reference in 4, thermal shutdown in 5, over-current A to D in 7 to
//! 10), held against Analog Devices' own driver (no-OS, `drivers/dac/ad5754r`), which agrees in all of them and in that
//! an answer stands in the second and third byte of the frame after the request.

mod load;

use core::fmt;

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;
pub use load::{Load, When};

use super::scaling::{FieldCode, TorqueCode};

/// Which part is fitted; they differ in the address of channel B and in the layout of the power register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// AD5754R, four channels, of which C and D stay powered down.
    Quad,
    /// AD5752R, two channels.
    Dual,
}

impl Part {
    fn address_b(self) -> u8 {
        match self {
            Self::Quad => 1,
            Self::Dual => 2,
        }
    }

    fn power_up_b(self) -> u16 {
        1 << self.address_b()
    }

    fn over_current_b(self) -> u16 {
        OVER_CURRENT_A << self.address_b()
    }
}

const READ: u8 = 0x80;
const REGISTER_DAC: u8 = 0 << 3;
const REGISTER_RANGE: u8 = 1 << 3;
const REGISTER_POWER: u8 = 2 << 3;
const REGISTER_CONTROL: u8 = 3 << 3;
const ADDRESS_A: u8 = 0;
/// Control register functions.
const NOP: u8 = 0;
const SETTINGS: u8 = 1;

const RANGE_UNIPOLAR_10_V: u16 = 0b001;
const RANGE_BIPOLAR_10_V: u16 = 0b100;
/// Thermal shutdown enabled, current clamp enabled, clear to 0 V, SDO on.
const CONTROL_SETTINGS: u16 = 0b1100;

const POWER_UP_A: u16 = 1 << 0;
const POWER_UP_REFERENCE: u16 = 1 << 4;
const THERMAL_SHUTDOWN: u16 = 1 << 5;
const OVER_CURRENT_A: u16 = 1 << 7;
/// After power-up and before the first code, us; the datasheet asks for 10.
const POWER_UP_US: u32 = 20;

/// What went wrong in talking to the part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Error<E> {
    /// The SPI bus reported an error.
    Bus(E),
    /// LDAC or CLR could not be driven.
    Pin,
    /// A register does not hold what was written to it.
    ReadBack {
        /// First byte of the frame: register and channel.
        register: u8,
        /// What was written.
        wrote: u16,
        /// What came back.
        read: u16,
    },
    /// An output stage has shut down or is at its current limit.
    Output(Status),
    /// LDAC has not fallen since the pair before was sent: the outputs do not follow.
    NotLoaded,
}

impl<E: fmt::Debug> fmt::Display for Error<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bus(e) => write!(f, "command DAC: SPI error {e:?}"),
            Self::Pin => write!(f, "command DAC: LDAC or CLR could not be driven"),
            Self::ReadBack { register, wrote, read } => write!(
                f,
                "command DAC: register {register:#04x} holds {read:#06x} after {wrote:#06x} was written; check its SPI wiring and supply"
            ),
            Self::Output(status) => write!(
                f,
                "command DAC: over-current A {}, over-current B {}, thermal shutdown {}",
                status.over_current_a, status.over_current_b, status.thermal_shutdown
            ),
            Self::NotLoaded => write!(f, "command DAC: LDAC did not fall, the outputs did not take the last commands"),
        }
    }
}

/// State of the output stages, from the power register.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Status {
    /// Channel A (torque) is at its current limit.
    pub over_current_a: bool,
    /// Channel B (field) is at its current limit.
    pub over_current_b: bool,
    /// The part is over 150 degrees C and has powered its outputs down.
    pub thermal_shutdown: bool,
}

impl Status {
    /// Whether both outputs are as commanded.
    pub fn is_ok(self) -> bool {
        self == Self::default()
    }
}

/// The pins beside the SPI port.
#[derive(Debug)]
pub struct Pins<Ldac, Clear> {
    /// LDAC; low transfers the written codes to the outputs.
    pub ldac: Ldac,
    /// CLR, active low; forces the outputs to 0 V.
    pub clear: Clear,
}

/// The converter on its SPI bus.
#[derive(Debug)]
pub struct Dac<Spi, Ldac, Clear> {
    spi: Spi,
    pins: Pins<Ldac, Clear>,
    part: Part,
    /// The next frame is the answer to the question for the state of the output stages.
    asked: bool,
}

impl<Spi: SpiDevice, Ldac: Load, Clear: OutputPin> Dac<Spi, Ldac, Clear> {
    /// Takes the port and the pins; nothing is sent before [`Self::init`].
    pub fn new(spi: Spi, pins: Pins<Ldac, Clear>, part: Part) -> Self {
        Self { spi, pins, part, asked: false }
    }

    /// Holds the outputs at 0 V, sets ranges, settings and power, reads each back, writes zero to both channels and only
    /// then lets the outputs go.
    ///
    /// # Errors
    ///
    /// Bus and pin errors, [`Error::ReadBack`], and [`Error::Output`] if an output stage is at its limit at 0 V. The
    /// outputs stay cleared after an error.
    pub fn init(&mut self, delay: &mut impl DelayNs) -> Result<(), Error<Spi::Error>> {
        drive(self.pins.clear.set_low())?;
        drive(self.pins.ldac.hold())?;
        self.asked = false;
        let b = self.part.address_b();
        let power = POWER_UP_REFERENCE | POWER_UP_A | self.part.power_up_b();

        self.write_verified(REGISTER_RANGE | ADDRESS_A, RANGE_BIPOLAR_10_V, 0b111)?;
        self.write_verified(REGISTER_RANGE | b, RANGE_UNIPOLAR_10_V, 0b111)?;
        self.write_verified(REGISTER_CONTROL | SETTINGS, CONTROL_SETTINGS, 0b1111)?;
        self.send(REGISTER_POWER, power)?;
        delay.delay_us(POWER_UP_US);
        let read = self.fetch(REGISTER_POWER)?;
        if read & power != power {
            return Err(Error::ReadBack { register: REGISTER_POWER, wrote: power, read });
        }
        let status = self.decode(read);
        if !status.is_ok() {
            return Err(Error::Output(status));
        }
        self.write_verified(REGISTER_DAC | ADDRESS_A, TorqueCode::ZERO.bits(), u16::MAX)?;
        self.write_verified(REGISTER_DAC | b, FieldCode::ZERO.bits(), u16::MAX)?;
        drive(self.pins.ldac.load())?;
        drive(self.pins.clear.set_high())
    }

    /// Writes both commands and makes them act together: two frames of 24 clocks with LDAC high, then it falls, at once or at
    /// its instant of the tick. False where that instant is past: they then act at once, as a pair all the same. LDAC stays low
    /// until the next write, so its minimum width (20 ns) needs no waiting.
    ///
    /// # Errors
    ///
    /// Bus and pin errors, [`Error::NotLoaded`], and what the answer to [`Self::write_and_ask`] says, if that was the last:
    /// [`Error::Output`], and [`Error::ReadBack`] if the part has lost its power settings (or does not answer). The outputs are
    /// cleared first, as one command without the other is none.
    pub fn write(&mut self, torque: TorqueCode, field: FieldCode, when: When) -> Result<bool, Error<Spi::Error>> {
        self.write_or_clear(torque, field, when, false)
    }

    /// As [`Self::write`], and asks for the state of the output stages behind the two, in one more frame. The next write takes
    /// the answer, so that nobody waits for it.
    ///
    /// # Errors
    ///
    /// As [`Self::write`].
    pub fn write_and_ask(
        &mut self,
        torque: TorqueCode,
        field: FieldCode,
        when: When,
    ) -> Result<bool, Error<Spi::Error>> {
        self.write_or_clear(torque, field, when, true)
    }

    /// Forces both outputs to 0 V by the pin; they stay there until [`Self::init`]. Needs no bus.
    ///
    /// # Errors
    ///
    /// [`Error::Pin`].
    pub fn clear(&mut self) -> Result<(), Error<Spi::Error>> {
        drive(self.pins.clear.set_low())
    }

    /// State of the output stages; two frames.
    ///
    /// # Errors
    ///
    /// Bus errors, and [`Error::ReadBack`] if the part has lost its power settings (or does not answer).
    pub fn status(&mut self) -> Result<Status, Error<Spi::Error>> {
        self.asked = false;
        let read = self.fetch(REGISTER_POWER)?;
        self.checked(read)
    }

    /// Gives port and pins back.
    pub fn release(self) -> (Spi, Pins<Ldac, Clear>) {
        (self.spi, self.pins)
    }

    fn decode(&self, power: u16) -> Status {
        Status {
            over_current_a: power & OVER_CURRENT_A != 0,
            over_current_b: power & self.part.over_current_b() != 0,
            thermal_shutdown: power & THERMAL_SHUTDOWN != 0,
        }
    }

    fn write_or_clear(
        &mut self,
        torque: TorqueCode,
        field: FieldCode,
        when: When,
        ask: bool,
    ) -> Result<bool, Error<Spi::Error>> {
        let written = self.write_both(torque, field, when, ask);
        if written.is_err() {
            self.asked = false;
            self.clear()?;
        }
        written
    }

    /// Nothing is on the bus any more when LDAC falls.
    fn write_both(
        &mut self,
        torque: TorqueCode,
        field: FieldCode,
        when: When,
        ask: bool,
    ) -> Result<bool, Error<Spi::Error>> {
        if !drive(self.pins.ldac.loaded())? {
            return Err(Error::NotLoaded);
        }
        drive(self.pins.ldac.hold())?;
        let answered = core::mem::take(&mut self.asked);
        let [high, low] = torque.bits().to_be_bytes();
        let mut frame = [REGISTER_DAC | ADDRESS_A, high, low];
        if answered {
            self.spi.transfer_in_place(&mut frame).map_err(Error::Bus)?;
        } else {
            self.spi.write(&frame).map_err(Error::Bus)?;
        }
        self.send(REGISTER_DAC | self.part.address_b(), field.bits())?;
        if ask {
            self.ask(REGISTER_POWER)?;
            self.asked = true;
        }
        let in_time = drive(match when {
            When::Now => self.pins.ldac.load().map(|()| true),
            When::OnTime => self.pins.ldac.load_on_time(),
        })?;
        if answered {
            let status = self.checked(u16::from_be_bytes([frame[1], frame[2]]))?;
            if !status.is_ok() {
                return Err(Error::Output(status));
            }
        }
        Ok(in_time)
    }

    fn write_verified(&mut self, register: u8, value: u16, mask: u16) -> Result<(), Error<Spi::Error>> {
        self.send(register, value)?;
        let read = self.fetch(register)? & mask;
        if read == value { Ok(()) } else { Err(Error::ReadBack { register, wrote: value, read }) }
    }

    fn send(&mut self, register: u8, value: u16) -> Result<(), Error<Spi::Error>> {
        let [high, low] = value.to_be_bytes();
        self.spi.write(&[register, high, low]).map_err(Error::Bus)
    }

    /// The state that the power register tells, if it holds what it should.
    fn checked(&self, read: u16) -> Result<Status, Error<Spi::Error>> {
        let power = POWER_UP_REFERENCE | POWER_UP_A | self.part.power_up_b();
        let status = self.decode(read);
        // A part in thermal shutdown clears its own power bits; that is its message, not a lost setting.
        if read & power != power && !status.thermal_shutdown {
            return Err(Error::ReadBack { register: REGISTER_POWER, wrote: power, read });
        }
        Ok(status)
    }

    /// Asks for a register, and clocks the answer out with a no-operation.
    fn fetch(&mut self, register: u8) -> Result<u16, Error<Spi::Error>> {
        self.ask(register)?;
        let mut frame = [REGISTER_CONTROL | NOP, 0, 0];
        self.spi.transfer_in_place(&mut frame).map_err(Error::Bus)?;
        Ok(u16::from_be_bytes([frame[1], frame[2]]))
    }

    fn ask(&mut self, register: u8) -> Result<(), Error<Spi::Error>> {
        self.spi.write(&[READ | register, 0, 0]).map_err(Error::Bus)
    }
}

fn drive<T, P, E>(result: Result<T, P>) -> Result<T, Error<E>> {
    result.map_err(|_| Error::Pin)
}
