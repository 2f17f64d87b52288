//! The fault register, bit by bit.

use bitflags::bitflags;

bitflags! {
    /// The fault register: what the part says about the signals it converts.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub struct Faults: u8 {
        /// D7.
        const CLIPPED = 0x80;
        /// D6.
        const LOSS_OF_SIGNAL = 0x40;
        /// D5.
        const OVERRANGE = 0x20;
        /// D4.
        const MISMATCH = 0x10;
        /// D3.
        const LOSS_OF_TRACKING = 0x08;
        /// D2.
        const OVER_SPEED = 0x04;
        /// D1.
        const PHASE = 0x02;
        /// D0.
        const CONFIG_PARITY = 0x01;
    }
}

impl Faults {
    /// One sentence for each bit that is set, from D7 down.
    pub fn sentences(self) -> impl Iterator<Item = &'static str> {
        self.iter().map(Self::sentence)
    }

    fn sentence(self) -> &'static str {
        match self {
            Self::CLIPPED => "a resolver input clips: the sine or cosine amplitude exceeds the converter's input range",
            Self::LOSS_OF_SIGNAL => {
                "a resolver input is below the loss-of-signal threshold: broken wire or no excitation"
            }
            Self::OVERRANGE => "a resolver input is above the overrange threshold: the excitation is too strong",
            Self::MISMATCH => {
                "sine and cosine amplitudes differ by more than the mismatch threshold: a winding or its wiring"
            }
            Self::LOSS_OF_TRACKING => "the tracking error exceeds its threshold: the position is not to be trusted",
            Self::OVER_SPEED => "the speed exceeds the tracking rate of the 12-bit mode",
            Self::PHASE => "the phase between excitation and resolver inputs exceeds the lock range",
            Self::CONFIG_PARITY => "a configuration register of the converter failed its parity check",
            // Unreachable by construction of `sentences`, and harmless: no bit, nothing to say.
            _ => "",
        }
    }
}
