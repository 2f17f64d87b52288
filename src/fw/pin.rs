//! Pins whose number is a value, without a path to a panic: the HAL checks the number of an erased pin at each write.

use core::convert::Infallible;

use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use stm32f4xx_hal::gpio::{Input, Output, PEPin, PinExt, PushPull};
use stm32f4xx_hal::pac;

/// A pin of a port, as set up by the HAL.
pub struct Wire<const PORT: char, Mode> {
    mask: u32,
    _pin: PEPin<PORT, Mode>,
}

/// An output.
pub type Out<const PORT: char> = Wire<PORT, Output<PushPull>>;
/// An input.
pub type In<const PORT: char> = Wire<PORT, Input>;

impl<const PORT: char, Mode> From<PEPin<PORT, Mode>> for Wire<PORT, Mode> {
    fn from(pin: PEPin<PORT, Mode>) -> Self {
        Self { mask: 1 << (pin.pin_id() & 15), _pin: pin }
    }
}

impl<const PORT: char, Mode> Wire<PORT, Mode> {
    fn registers() -> &'static pac::gpioa::RegisterBlock {
        let port = match PORT {
            'A' => pac::GPIOA::ptr(),
            'B' => pac::GPIOB::ptr().cast(),
            _ => pac::GPIOC::ptr().cast(),
        };
        // SAFETY: the ports have one layout as far as IDR and BSRR go, and this pin is only ours.
        #[allow(unsafe_code)]
        unsafe {
            &*port
        }
    }

    fn write(bits: u32) {
        // SAFETY: BSRR changes the pins it names and no other.
        #[allow(unsafe_code)]
        Self::registers().bsrr().write(|w| unsafe { w.bits(bits) });
    }
}

impl<const PORT: char, Mode> ErrorType for Wire<PORT, Mode> {
    type Error = Infallible;
}

impl<const PORT: char> OutputPin for Out<PORT> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Self::write(self.mask << 16);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Self::write(self.mask);
        Ok(())
    }
}

impl<const PORT: char> InputPin for In<PORT> {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(Self::registers().idr().read().bits() & self.mask != 0)
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}
