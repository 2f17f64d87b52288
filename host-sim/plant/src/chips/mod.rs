//! The chips around the MCU, modelled at the level of SPI bytes and pins.
//!
//! A chip is a plain state machine behind the trait [`Chip`]: it is selected, handed bytes, deselected, and has pins. What
//! carries the bytes is not its business: [`hal`] carries them from the real drivers through the embedded-hal traits, and
//! the emulated board carries them from the SPI peripherals of the emulated MCU. The side of the chip that faces the
//! machine (an angle in, a torque and a field out) and the faults that can be put into it are methods of its own.

pub mod ad2s1210;
pub mod dac;
pub mod hal;

pub use ad2s1210::Ad2s1210;
pub use dac::Dac;

/// A chip on an SPI bus with a select line and some pins.
pub trait Chip {
    /// The pins of the chip that the MCU drives.
    type Pin: Copy;

    /// The select line goes to its active level.
    fn select(&mut self);

    /// Eight clocks: takes a byte, gives the byte that comes out meanwhile.
    fn transfer(&mut self, mosi: u8) -> u8;

    /// The select line goes back.
    fn deselect(&mut self);

    /// A pin takes a level; the same level again is no edge.
    fn set_pin(&mut self, pin: Self::Pin, high: bool);

    /// Time passes, s.
    fn advance(&mut self, dt_s: f64);
}

/// What the MCU sees instead of the chip's answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BusFault {
    /// The answers, as they are.
    #[default]
    None,
    /// Data line stuck low.
    AllZeros,
    /// Data line stuck high, or the chip unpowered with a pull-up.
    AllOnes,
    /// Seeded noise.
    Garbage,
}

/// The data line with a fault on it. The noise is a 64-bit xorshift: reproducible, and nothing depends on its quality.
#[derive(Debug, Clone, Copy)]
struct Line {
    fault: BusFault,
    noise: u64,
}

impl Line {
    fn new() -> Self {
        Self { fault: BusFault::None, noise: 0x9E37_79B9_7F4A_7C15 }
    }

    fn set(&mut self, fault: BusFault, seed: u64) {
        self.fault = fault;
        // Zero is the fixed point of a xorshift.
        self.noise = seed ^ 0x9E37_79B9_7F4A_7C15;
        if self.noise == 0 {
            self.noise = 1;
        }
    }

    fn carry(&mut self, answer: u8) -> u8 {
        match self.fault {
            BusFault::None => answer,
            BusFault::AllZeros => 0x00,
            BusFault::AllOnes => 0xFF,
            BusFault::Garbage => {
                self.noise ^= self.noise << 13;
                self.noise ^= self.noise >> 7;
                self.noise ^= self.noise << 17;
                (self.noise >> 32) as u8
            }
        }
    }
}
