//! A chip of the `plant` crate on an SPI controller of the emulated MCU.

use plant::chips::Chip;
use rigless::chip::Timeline;
use rigless::chip::spi::Peer;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;

/// The chip, and the instant up to which its time has passed.
#[derive(Debug)]
pub struct OnBus<C> {
    /// The chip.
    pub chip: C,
    now: VirtualNanos,
}

impl<C: Chip> OnBus<C> {
    /// The chip at power-up, at time zero.
    pub fn new(chip: C) -> Self {
        Self { chip, now: VirtualNanos(0) }
    }

    /// Lets the chip's time pass up to `now`.
    pub fn advance_to(&mut self, now: VirtualNanos) {
        self.chip.advance(now.0.saturating_sub(self.now.0) as f64 * 1e-9);
        self.now = now;
    }
}

// Nothing is kept: a run on this board is never resumed from a snapshot.
impl<C> Store for OnBus<C> {}

impl<C: Chip + std::fmt::Debug + Send + 'static> Peer for OnBus<C> {
    fn transfer(&mut self, mosi: u32, bits: u8, _context: &mut Timeline<'_, '_>) -> u32 {
        // Both chips take whole bytes; a frame of 16 bits is two of them.
        (0..bits / 8)
            .rev()
            .fold(0, |answer, nth| answer << 8 | u32::from(self.chip.transfer((mosi >> (8 * nth)) as u8)))
    }

    fn select(&mut self, context: &mut Timeline<'_, '_>) {
        self.advance_to(context.now());
        self.chip.select();
    }

    fn deselect(&mut self, _context: &mut Timeline<'_, '_>) {
        self.chip.deselect();
    }
}
