//! The sectors of flash that the image programs.
//!
//! The emulator's model of the flash interface has the registers and the times of an erase, but drops what the firmware
//! stores to the array. This is the array of the sectors that hold parameters and events, with the rules of RM0090 chapter
//! 3.6: programming clears bits and sets none, an erase sets all of a sector, and neither happens while the control
//! register is locked, programming is not enabled, or an operation runs. A store that breaks a rule changes nothing and is
//! counted.
//!
//! Every change is also written down in its order, so that the array can be had as it stood, had the power failed at any of
//! them.

use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rigless::soc::Width;

/// Where the array is in the address space: sectors 1 and 2 with the parameters, sector 3 with the event log.
pub const ADDRESSES: Range<u64> = 0x0800_4000..0x0801_0000;
/// Bytes of one of the sectors.
pub const SECTOR_BYTES: usize = 0x4000;
/// First of them in the flash interface's numbers.
const FIRST_SECTOR: u64 = 1;

/// Bits of the control register.
const CR_PROGRAM: u64 = 1 << 0;
const CR_SECTOR_ERASE: u64 = 1 << 1;
const CR_SECTOR: Range<u32> = 3..8;
const CR_WIDTH: Range<u32> = 8..10;
const CR_LOCK: u64 = 1 << 31;
/// Bit of the status register.
const SR_BUSY: u64 = 1 << 16;

/// A change of the array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// A byte was programmed.
    Program {
        /// Offset in the array.
        at: usize,
        /// What was stored; the bits that are 0 in it are cleared.
        byte: u8,
    },
    /// A sector was erased.
    Erase {
        /// Its offset in the array.
        from: usize,
    },
}

impl Change {
    /// Does to `array` what this change does.
    pub fn apply(self, array: &mut [u8]) {
        match self {
            Self::Program { at, byte } => {
                if let Some(cell) = array.get_mut(at) {
                    *cell &= byte;
                }
            }
            Self::Erase { from } => array.iter_mut().skip(from).take(SECTOR_BYTES).for_each(|cell| *cell = 0xFF),
        }
    }
}

/// The array and its history.
#[derive(Debug, Clone)]
pub struct Array {
    /// What it holds.
    pub bytes: Vec<u8>,
    /// What the image did to it since the run began.
    pub changes: Vec<Change>,
    /// Stores and erases that broke a rule.
    pub refused: usize,
}

impl Default for Array {
    /// Erased.
    fn default() -> Self {
        Self::holding(Vec::new())
    }
}

impl Array {
    /// As an earlier run left it, erased where `bytes` say nothing.
    pub fn holding(mut bytes: Vec<u8>) -> Self {
        bytes.resize((ADDRESSES.end - ADDRESSES.start) as usize, 0xFF);
        Self { bytes, changes: Vec::new(), refused: 0 }
    }

    /// The value at an address.
    pub fn read(&self, address: u64, width: Width) -> u64 {
        let cells = (0..u64::from(width.bytes())).map(|byte| {
            let at = usize::try_from(address + byte - ADDRESSES.start).unwrap_or(usize::MAX);
            u64::from(self.bytes.get(at).copied().unwrap_or(0xFF)) << (8 * byte)
        });
        cells.fold(0, |value, cell| value | cell)
    }

    /// A store by the image, with the registers as they stand.
    pub fn store(&mut self, address: u64, width: Width, value: u64, control: u64, status: u64) {
        let widths_match = field(control, CR_WIDTH) == u64::from(width.bytes().trailing_zeros());
        let enabled = control & CR_PROGRAM != 0 && control & (CR_LOCK | CR_SECTOR_ERASE) == 0;
        if !widths_match || !enabled || status & SR_BUSY != 0 {
            self.refused += 1;
            return;
        }
        for byte in 0..u64::from(width.bytes()) {
            let at = usize::try_from(address + byte - ADDRESSES.start).unwrap_or(usize::MAX);
            self.change(Change::Program { at, byte: (value >> (8 * byte)) as u8 });
        }
    }

    /// An erase that the flash interface has accepted, by what was written to its control register.
    pub fn erase(&mut self, control: u64) {
        let nth = field(control, CR_SECTOR).wrapping_sub(FIRST_SECTOR);
        let from = usize::try_from(nth).unwrap_or(usize::MAX).saturating_mul(SECTOR_BYTES);
        if control & CR_SECTOR_ERASE == 0 || from >= self.bytes.len() {
            // The sectors of the image itself: it must never ask for that.
            self.refused += 1;
            return;
        }
        self.change(Change::Erase { from });
    }

    fn change(&mut self, change: Change) {
        change.apply(&mut self.bytes);
        self.changes.push(change);
    }
}

fn field(register: u64, bits: Range<u32>) -> u64 {
    register >> bits.start & ((1 << (bits.end - bits.start)) - 1)
}

/// The array as the core and the world share it.
#[derive(Debug, Clone, Default)]
pub struct Shared(Arc<Mutex<Array>>);

impl Shared {
    /// Shares an array.
    pub fn new(array: Array) -> Self {
        Self(Arc::new(Mutex::new(array)))
    }

    /// Borrows it. Each change is whole, so that a holder that panicked has left it usable.
    pub fn lock(&self) -> MutexGuard<'_, Array> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENABLED: u64 = CR_PROGRAM;

    #[test]
    fn programming_clears_bits_and_only_an_erase_sets_them() {
        let mut array = Array::default();
        array.store(ADDRESSES.start + 5, Width::W8, 0xF0, ENABLED, 0);
        array.store(ADDRESSES.start + 5, Width::W8, 0x3C, ENABLED, 0);
        assert_eq!(array.read(ADDRESSES.start + 4, Width::W32), 0xFFFF_30FF);
        array.erase(CR_SECTOR_ERASE | 2 << 3);
        assert_eq!(array.bytes[5], 0x30, "that was the other sector");
        array.erase(CR_SECTOR_ERASE | 1 << 3);
        assert_eq!(array.bytes[5], 0xFF);
        assert_eq!((array.changes.len(), array.refused), (4, 0));
    }

    #[test]
    fn what_breaks_a_rule_changes_nothing() {
        let mut array = Array::default();
        array.store(ADDRESSES.start, Width::W8, 0, 0, 0);
        array.store(ADDRESSES.start, Width::W8, 0, ENABLED | CR_LOCK, 0);
        array.store(ADDRESSES.start, Width::W8, 0, ENABLED, SR_BUSY);
        array.store(ADDRESSES.start, Width::W32, 0, ENABLED, 0);
        array.erase(CR_SECTOR_ERASE | 4 << 3);
        array.erase(CR_SECTOR_ERASE);
        assert_eq!((array.bytes, array.refused), (Array::default().bytes, 6));
    }
}
