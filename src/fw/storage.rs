//! The places of parameters (sectors 1 and 2) and of the event log (sector 3) in flash, 16 KiB each.

use core::ops::Range;

use embassy_futures::block_on;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use er_servo::Config;
use er_servo::events::{Event, EventLog};
use er_servo::storage::{self, StorageError};
use stm32f4xx_hal::flash::{self, FlashExt, LockedFlash};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

use super::board::WATCHDOG_MS;
use super::{clock, tick};

/// Offsets from the start of flash; memory.x keeps the image out of it.
const RANGE: Range<u32> = 0x4000..0xC000;
const EVENTS: Range<u32> = 0xC000..0x1_0000;
const SECTOR_BYTES: u32 = 0x4000;
/// Erasing a 16 KiB sector byte by byte takes 400 ms, at most 800 (datasheet table 48), and the core stands still.
const ERASE_WATCHDOG_MS: u32 = 2000;

/// Parameters and events in flash.
pub struct Storage {
    flash: LockedFlash,
    /// None where the flash could not be read or erased.
    events: Option<EventLog>,
}

impl Storage {
    /// On the flash interface. An event log that is nearly full is tidied, which takes up to a second.
    pub fn new(mut flash: LockedFlash) -> Self {
        let events = block_on(EventLog::open(&mut Sectors { flash: &mut flash, range: EVENTS }, EVENTS)).ok();
        Self { flash, events }
    }

    /// Writes an event, only while the drive stands still: each byte holds the core up for 16 us. An event that cannot be
    /// written is in the log over RTT all the same.
    pub fn log_event(&mut self, event: &Event) {
        let sectors = &mut Sectors { flash: &mut self.flash, range: EVENTS };
        let _ = self.events.as_mut().map(|events| block_on(events.append(sectors, event)));
    }

    /// The newest event but `back`.
    pub fn event(&mut self, back: u8) -> Option<Event> {
        let sectors = &mut Sectors { flash: &mut self.flash, range: EVENTS };
        self.events.as_ref().and_then(|events| block_on(events.newest(sectors, back)).ok()?)
    }

    /// Whether the next event would find no room.
    pub fn events_are_full(&self) -> bool {
        self.events.as_ref().is_some_and(EventLog::is_full)
    }

    /// Makes room for events. Where that fails the next are in the log over RTT all the same.
    pub fn make_room_for_events(&mut self, watchdog: &mut IndependentWatchdog) {
        let Self { flash, events } = self;
        patiently(watchdog, || {
            let sectors = &mut Sectors { flash, range: EVENTS };
            let _ = events.as_mut().map(|events| block_on(events.make_room(sectors)));
        });
    }

    /// The stored set.
    pub fn load(&mut self) -> Result<Config, StorageError> {
        block_on(storage::load(Sectors { flash: &mut self.flash, range: RANGE }, RANGE))
    }

    /// The newest set that this image can read, where the newest is of another release.
    pub fn load_older(&mut self) -> Result<Config, StorageError> {
        block_on(storage::load_older(Sectors { flash: &mut self.flash, range: RANGE }, RANGE))
    }

    /// Stores the set.
    pub fn save(&mut self, config: &Config, watchdog: &mut IndependentWatchdog) -> Result<(), StorageError> {
        let sectors = Sectors { flash: &mut self.flash, range: RANGE };
        patiently(watchdog, || block_on(storage::save(sectors, RANGE, config)))
    }
}

/// Runs what may erase a sector, with ticks paused and the watchdog patient.
fn patiently<T>(watchdog: &mut IndependentWatchdog, act: impl FnOnce() -> T) -> T {
    tick::paused(|| {
        clock::set_watchdog(watchdog, ERASE_WATCHDOG_MS);
        let result = act();
        watchdog.start(WATCHDOG_MS.millis());
        result
    })
}

/// Empties the data cache of the flash interface, which does not learn of an erase (RM0090 section 3.6.3, note) and would
/// go on giving what was there before. Programming it does follow.
fn forget_cached_data() {
    // SAFETY: only the data cache's bits of ACR are changed, and nothing else changes ACR after the clocks are set up.
    #[allow(unsafe_code)]
    let registers = unsafe { &*pac::FLASH::ptr() };
    registers.acr().modify(|_, w| w.dcen().clear_bit());
    registers.acr().modify(|_, w| w.dcrst().set_bit());
    registers.acr().modify(|_, w| w.dcrst().clear_bit());
    registers.acr().modify(|_, w| w.dcen().set_bit());
}

/// Some sectors, for the library.
struct Sectors<'a> {
    flash: &'a mut LockedFlash,
    range: Range<u32>,
}

/// The flash interface reported an error, or the place is not one of those sectors.
#[derive(Debug)]
struct Failed;

impl NorFlashError for Failed {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl From<flash::Error> for Failed {
    fn from(_: flash::Error) -> Self {
        Self
    }
}

impl ErrorType for Sectors<'_> {
    type Error = Failed;
}

impl ReadNorFlash for Sectors<'_> {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failed> {
        let stored = self.flash.read().get(offset as usize..).and_then(|rest| rest.get(..bytes.len())).ok_or(Failed)?;
        bytes.copy_from_slice(stored);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.range.end as usize
    }
}

impl NorFlash for Sectors<'_> {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR_BYTES as usize;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        let sectors = from / SECTOR_BYTES..to / SECTOR_BYTES;
        if !self.range.contains(&from) || to > self.range.end {
            return Err(Failed);
        }
        let mut unlocked = self.flash.unlocked();
        let erased = sectors.into_iter().try_for_each(|sector| unlocked.erase(sector as u8));
        drop(unlocked);
        forget_cached_data();
        Ok(erased?)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        if !self.range.contains(&offset) {
            return Err(Failed);
        }
        self.flash.unlocked().program(offset as usize, bytes.iter())?;
        Ok(())
    }
}
