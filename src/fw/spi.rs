//! The two SPI buses, each with its one chip, without a path to a panic: the tick runs through here.

use embedded_hal::digital::OutputPin;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::spi::{Error, Instance, Spi};

use super::pin::Out;

/// A bus and the select line of its chip.
pub struct Device<S: Instance, const PORT: char> {
    spi: Spi<S>,
    select: Out<PORT>,
}

impl<S: Instance, const PORT: char> Device<S, PORT> {
    /// The bus, with its chip not selected.
    pub fn new(spi: Spi<S>, mut select: Out<PORT>) -> Self {
        // These pins cannot fail.
        let _ = select.set_high();
        Self { spi, select }
    }

    fn exchange(&mut self, byte: u8) -> Result<u8, Error> {
        nb::block!(self.spi.write_nonblocking(byte))?;
        nb::block!(self.spi.read_nonblocking())
    }

    /// Keeps one byte in the bus's buffer while the one before goes out.
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let Some((first, rest)) = bytes.split_first() else { return Ok(()) };
        nb::block!(self.spi.write_nonblocking(*first))?;
        for byte in rest {
            nb::block!(self.spi.write_nonblocking(*byte))?;
            nb::block!(self.spi.read_nonblocking())?;
        }
        nb::block!(self.spi.read_nonblocking()).map(|_| ())
    }

    fn carry_out(&mut self, operation: &mut Operation<'_, u8>) -> Result<(), Error> {
        match operation {
            Operation::Write(bytes) => self.send(bytes),
            Operation::Read(bytes) => bytes.iter_mut().try_for_each(|byte| {
                *byte = self.exchange(0)?;
                Ok(())
            }),
            Operation::TransferInPlace(bytes) => bytes.iter_mut().try_for_each(|byte| {
                *byte = self.exchange(*byte)?;
                Ok(())
            }),
            Operation::Transfer(read, write) => {
                let (mut read, mut write) = (read.iter_mut(), write.iter());
                loop {
                    match (read.next(), write.next()) {
                        (None, None) => return Ok(()),
                        (place, byte) => {
                            let answer = self.exchange(byte.copied().unwrap_or(0))?;
                            if let Some(place) = place {
                                *place = answer;
                            }
                        }
                    }
                }
            }
            Operation::DelayNs(wait_ns) => {
                embedded_hal::delay::DelayNs::delay_ns(&mut super::board::CycleDelay, *wait_ns);
                Ok(())
            }
        }
    }
}

impl<S: Instance, const PORT: char> ErrorType for Device<S, PORT> {
    type Error = Error;
}

impl<S: Instance, const PORT: char> SpiDevice for Device<S, PORT> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Error> {
        let _ = self.select.set_low();
        let outcome = operations.iter_mut().try_for_each(|operation| self.carry_out(operation));
        let _ = self.select.set_high();
        outcome
    }
}

/// SPI2 at 21 MHz while only written to, at 10.5 MHz to read: the DAC takes 30 MHz, its answers need 90 ns a clock. The
/// tick only writes, and so waits half as long.
pub struct FastWrites<D> {
    device: D,
    fast: bool,
}

impl<D> FastWrites<D> {
    /// Slow, until something is only written.
    pub fn new(device: D) -> Self {
        Self { device, fast: false }
    }

    fn clock(&mut self, fast: bool) {
        if fast == self.fast {
            return;
        }
        self.fast = fast;
        // SAFETY: SPI2 is this device's own, and no transfer runs between two transactions.
        #[allow(unsafe_code)]
        let registers = unsafe { &*pac::SPI2::ptr() };
        registers.cr1().modify(|_, w| w.spe().clear_bit());
        registers.cr1().modify(|_, w| if fast { w.br().div2() } else { w.br().div4() });
        registers.cr1().modify(|_, w| w.spe().set_bit());
    }
}

impl<D: SpiDevice> ErrorType for FastWrites<D> {
    type Error = D::Error;
}

impl<D: SpiDevice> SpiDevice for FastWrites<D> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), D::Error> {
        self.clock(operations.iter().all(|operation| matches!(operation, Operation::Write(_))));
        self.device.transaction(operations)
    }
}
