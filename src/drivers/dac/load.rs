//! LDAC, and when it falls.

use embedded_hal::digital::OutputPin;

/// When a pair of commands acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum When {
    /// As soon as both are written.
    Now,
    /// At LDAC's instant of the tick, however long it has taken to work them out.
    OnTime,
}

/// LDAC: low transfers the written codes of both channels to the outputs. Any output pin is one, and falls when it is told to;
/// one that a timer drives falls at its instant of the tick.
pub trait Load {
    /// Why it could not be driven or read.
    type Error;

    /// Whether it has fallen since it was last raised.
    ///
    /// # Errors
    /// See [`Self::Error`].
    fn loaded(&mut self) -> Result<bool, Self::Error>;
    /// High: what is written from now on waits.
    ///
    /// # Errors
    /// See [`Self::Error`].
    fn hold(&mut self) -> Result<(), Self::Error>;
    /// Falls at once.
    ///
    /// # Errors
    /// See [`Self::Error`].
    fn load(&mut self) -> Result<(), Self::Error>;
    /// Falls at its instant of this tick, or at once where that is past; false where it is.
    ///
    /// # Errors
    /// See [`Self::Error`].
    fn load_on_time(&mut self) -> Result<bool, Self::Error>;
}

impl<P: OutputPin> Load for P {
    type Error = P::Error;

    fn loaded(&mut self) -> Result<bool, P::Error> {
        Ok(true)
    }

    fn hold(&mut self) -> Result<(), P::Error> {
        self.set_high()
    }

    fn load(&mut self) -> Result<(), P::Error> {
        self.set_low()
    }

    fn load_on_time(&mut self) -> Result<bool, P::Error> {
        self.set_low().map(|()| true)
    }
}
