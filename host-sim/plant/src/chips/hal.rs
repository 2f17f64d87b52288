//! The chips behind the embedded-hal traits, so that the real drivers talk to them.
//!
//! One chip is shared by the SPI port, the pins and the delay that are handed to the driver, and by the test that moves
//! the rotor and puts faults in; hence the shared ownership. All of it is single-threaded.

use std::cell::RefCell;
use std::convert::Infallible;
use std::rc::Rc;

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, ErrorKind, Operation, SpiDevice};

use super::Chip;

/// A chip and the wires to it.
#[derive(Debug)]
pub struct Socket<C> {
    wired: Rc<RefCell<Wired<C>>>,
}

#[derive(Debug)]
struct Wired<C> {
    chip: C,
    spi_error: Option<ErrorKind>,
}

impl<C> Clone for Socket<C> {
    fn clone(&self) -> Self {
        Self { wired: Rc::clone(&self.wired) }
    }
}

impl<C: Chip> Socket<C> {
    /// Puts the chip into its socket.
    pub fn new(chip: C) -> Self {
        Self { wired: Rc::new(RefCell::new(Wired { chip, spi_error: None })) }
    }

    /// The side of the chip that faces the machine, and its faults.
    pub fn with<T>(&self, act: impl FnOnce(&mut C) -> T) -> T {
        act(&mut self.wired.borrow_mut().chip)
    }

    /// Makes every transaction fail with `error`, or work again.
    pub fn fail_spi(&self, error: Option<ErrorKind>) {
        self.wired.borrow_mut().spi_error = error;
    }

    /// Port with select line, for a driver.
    pub fn spi(&self) -> SpiPort<C> {
        SpiPort { socket: self.clone() }
    }

    /// One pin of the chip, for a driver.
    pub fn pin(&self, pin: C::Pin) -> ChipPin<C> {
        ChipPin { socket: self.clone(), pin }
    }

    /// A delay in which the chip's time passes.
    pub fn delay(&self) -> ChipDelay<C> {
        ChipDelay { socket: self.clone() }
    }
}

/// SPI port of one chip.
#[derive(Debug)]
pub struct SpiPort<C> {
    socket: Socket<C>,
}

impl<C: Chip> spi::ErrorType for SpiPort<C> {
    type Error = ErrorKind;
}

impl<C: Chip> SpiDevice for SpiPort<C> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let mut wired = self.socket.wired.borrow_mut();
        if let Some(error) = wired.spi_error {
            return Err(error);
        }
        let chip = &mut wired.chip;
        chip.select();
        for operation in operations {
            match operation {
                Operation::Read(read) => read.iter_mut().for_each(|byte| *byte = chip.transfer(0)),
                Operation::Write(write) => write.iter().for_each(|byte| {
                    chip.transfer(*byte);
                }),
                Operation::Transfer(read, write) => transfer(chip, read, write),
                Operation::TransferInPlace(words) => words.iter_mut().for_each(|byte| *byte = chip.transfer(*byte)),
                Operation::DelayNs(wait_ns) => chip.advance(f64::from(*wait_ns) * 1e-9),
            }
        }
        chip.deselect();
        Ok(())
    }
}

/// The shorter of the two is made up with zeros sent, or answers dropped, as the trait says.
fn transfer(chip: &mut impl Chip, read: &mut [u8], write: &[u8]) {
    for at in 0..read.len().max(write.len()) {
        let answer = chip.transfer(write.get(at).copied().unwrap_or(0));
        if let Some(byte) = read.get_mut(at) {
            *byte = answer;
        }
    }
}

/// One pin of a chip.
#[derive(Debug)]
pub struct ChipPin<C: Chip> {
    socket: Socket<C>,
    pin: C::Pin,
}

impl<C: Chip> digital::ErrorType for ChipPin<C> {
    type Error = Infallible;
}

impl<C: Chip> OutputPin for ChipPin<C> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.socket.with(|chip| chip.set_pin(self.pin, false));
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.socket.with(|chip| chip.set_pin(self.pin, true));
        Ok(())
    }
}

/// A delay in which a chip's time passes.
#[derive(Debug)]
pub struct ChipDelay<C> {
    socket: Socket<C>,
}

impl<C: Chip> DelayNs for ChipDelay<C> {
    fn delay_ns(&mut self, wait_ns: u32) {
        self.socket.with(|chip| chip.advance(f64::from(wait_ns) * 1e-9));
    }
}
