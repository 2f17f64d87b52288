//! The last faults, in flash: what a person asks for after the drive was found standing still.
//!
//! One sector is a log of records; each begins with its number and a check, so that a record that a power failure has torn
//! is passed over. A sector that is nearly full is tidied when the drive starts, a full one when a fault is cleared, so that
//! the next fault finds room: the newest records are kept in memory while it is erased and written back, so a power failure
//! in that half second loses them.
//!
//! | bytes of a record | content |
//! |---|---|
//! | 0..4 | number, counted up |
//! | 4..8 | CRC-32 of all other bytes |
//! | 8..12 | faults, bits of [`Faults`] |
//! | 12..16 | time since the reset, ms |
//! | 16..20 | position, counts |
//! | 20..24 | speed, rad/s, single precision |
//! | 24..28 | most cycles of a tick |
//! | 28 | fault byte of the resolver converter |
//! | 29 | why the drive had restarted ([`Restart`]): 0 nothing noted, 1 watchdog, 2 panic, 3 hard fault, 4 crystal, 5 interrupt |
//! | 30..32 | line of the panic, or number of the interrupt |

use core::ops::Range;

use embedded_storage_async::nor_flash::NorFlash;
use serde::{Deserialize, Serialize};

use crate::Faults;
use crate::storage::StorageError;

/// Records that are kept when the sector is tidied.
pub const KEPT: usize = 64;
/// Bytes of a record.
const RECORD_BYTES: usize = 32;
const ERASED: u8 = 0xFF;
const CRC: crc::Crc<u32, crc::NoTable> = crc::Crc::<u32, crc::NoTable>::new(&crc::CRC_32_ISO_HDLC);

type Record = [u8; RECORD_BYTES];

/// A fault, and how the drive was when it was latched.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Event {
    /// Number of the fault since the log was first written.
    pub number: u32,
    /// Bits of [`Faults`].
    pub faults: u32,
    /// Time since the reset before it, ms.
    pub at_ms: u32,
    /// Position, counts.
    pub position: i32,
    /// Speed, rad/s.
    pub speed_rad_s: f32,
    /// Most cycles of a tick so far.
    pub worst_cycles: u32,
    /// Fault byte of the resolver converter.
    pub resolver_faults: u8,
    /// Of [`Faults::ABNORMAL_RESET`], what had happened before the reset.
    pub restart: Option<Restart>,
}

/// Why the drive had to be restarted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Restart {
    /// The watchdog, and nothing was noted: ticks or thread mode hung, or the core was halted.
    Watchdog,
    /// A panic at this line; of which file, only the log over RTT has room for.
    Panic(u16),
    /// A hard fault.
    HardFault,
    /// The crystal failed.
    ClockFailed,
    /// An interrupt of this number, which has no handler.
    Interrupt(u16),
}

impl Restart {
    /// Bytes 29..32 of a record.
    fn encode(restart: Option<Self>) -> [u8; 3] {
        let (kind, place) = match restart {
            None => (0, 0),
            Some(Self::Watchdog) => (1, 0),
            Some(Self::Panic(line)) => (2, line),
            Some(Self::HardFault) => (3, 0),
            Some(Self::ClockFailed) => (4, 0),
            Some(Self::Interrupt(number)) => (5, number),
        };
        let [low, high] = place.to_le_bytes();
        [kind, low, high]
    }

    fn decode([kind, low, high]: [u8; 3]) -> Option<Self> {
        let place = u16::from_le_bytes([low, high]);
        match kind {
            1 => Some(Self::Watchdog),
            2 => Some(Self::Panic(place)),
            3 => Some(Self::HardFault),
            4 => Some(Self::ClockFailed),
            5 => Some(Self::Interrupt(place)),
            _ => None,
        }
    }
}

impl core::fmt::Display for Restart {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Watchdog => {
                f.write_str("the watchdog restarted it: ticks or thread mode hung, or the core was halted")
            }
            Self::Panic(line) => write!(f, "it panicked at line {line}; the log over RTT names the file"),
            Self::HardFault => f.write_str("hard fault; the log over RTT has its address"),
            Self::ClockFailed => f.write_str("the crystal failed: check it and its capacitors"),
            Self::Interrupt(number) => write!(f, "interrupt {number} has no handler"),
        }
    }
}

impl Event {
    /// The faults as such; bits of a later release are left out.
    pub fn faults(&self) -> Faults {
        Faults::from_bits_truncate(self.faults)
    }

    fn encode(&self) -> Record {
        let mut record = [0; RECORD_BYTES];
        let words = [self.faults, self.at_ms, self.position as u32, self.speed_rad_s.to_bits(), self.worst_cycles];
        record[..4].copy_from_slice(&self.number.to_le_bytes());
        for (place, word) in record[8..].as_chunks_mut::<4>().0.iter_mut().zip(words) {
            *place = word.to_le_bytes();
        }
        record[28] = self.resolver_faults;
        record[29..].copy_from_slice(&Restart::encode(self.restart));
        let check = check(&record);
        record[4..8].copy_from_slice(&check.to_le_bytes());
        record
    }

    fn decode(record: &Record) -> Option<Self> {
        let word = |at: usize| u32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]);
        (word(4) == check(record)).then(|| Self {
            number: word(0),
            faults: word(8),
            at_ms: word(12),
            position: word(16) as i32,
            speed_rad_s: f32::from_bits(word(20)),
            worst_cycles: word(24),
            resolver_faults: record[28],
            restart: Restart::decode([record[29], record[30], record[31]]),
        })
    }
}

fn check(record: &Record) -> u32 {
    let mut digest = CRC.digest();
    digest.update(&record[..4]);
    digest.update(&record[8..]);
    digest.finalize()
}

/// Where the log stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EventLog {
    range: Range<u32>,
    /// Place of the next record; the end of the range when it is full.
    next_at: u32,
    next_number: u32,
}

impl EventLog {
    /// Finds the end of the log in a sector, and makes room where there is not enough for [`KEPT`] more.
    ///
    /// # Errors
    /// [`StorageError::Flash`].
    pub async fn open<F: NorFlash>(flash: &mut F, range: Range<u32>) -> Result<Self, StorageError> {
        let mut log = Self { next_at: range.start, range, next_number: 0 };
        for at in log.range.clone().step_by(RECORD_BYTES) {
            let record = read(flash, at).await?;
            if let Some(event) = Event::decode(&record) {
                log.next_number = log.next_number.max(event.number.wrapping_add(1));
            }
            if record.iter().any(|byte| *byte != ERASED) {
                log.next_at = at + RECORD_BYTES as u32;
            }
        }
        if log.range.end - log.next_at < (KEPT * RECORD_BYTES) as u32 {
            log.tidy(flash).await?;
        }
        Ok(log)
    }

    /// Whether the next event would find no room.
    pub fn is_full(&self) -> bool {
        self.next_at >= self.range.end
    }

    /// Makes room in a full sector; the last [`KEPT`] stay.
    ///
    /// # Errors
    /// [`StorageError::Flash`].
    pub async fn make_room<F: NorFlash>(&mut self, flash: &mut F) -> Result<(), StorageError> {
        if self.is_full() { self.tidy(flash).await } else { Ok(()) }
    }

    /// Writes an event behind the others; one that finds the sector full is dropped.
    ///
    /// # Errors
    /// [`StorageError::Flash`].
    pub async fn append<F: NorFlash>(&mut self, flash: &mut F, event: &Event) -> Result<(), StorageError> {
        if self.is_full() {
            return Ok(());
        }
        let record = Event { number: self.next_number, ..*event }.encode();
        let at = self.next_at;
        // Whatever becomes of it, the place is used.
        self.next_at += RECORD_BYTES as u32;
        self.next_number = self.next_number.wrapping_add(1);
        flash.write(at, &record).await.map_err(|_| StorageError::Flash)
    }

    /// The newest event but `back`.
    ///
    /// # Errors
    /// [`StorageError::Flash`].
    pub async fn newest<F: NorFlash>(&self, flash: &mut F, back: u8) -> Result<Option<Event>, StorageError> {
        let (mut at, mut left) = (self.next_at, back);
        while at > self.range.start {
            at -= RECORD_BYTES as u32;
            if let Some(event) = Event::decode(&read(flash, at).await?) {
                if left == 0 {
                    return Ok(Some(event));
                }
                left -= 1;
            }
        }
        Ok(None)
    }

    async fn tidy<F: NorFlash>(&mut self, flash: &mut F) -> Result<(), StorageError> {
        let mut kept = [[0; RECORD_BYTES]; KEPT];
        let mut count = 0;
        for (back, place) in (0..).zip(&mut kept) {
            let Some(event) = self.newest(flash, back).await? else { break };
            *place = event.encode();
            count += 1;
        }
        flash.erase(self.range.start, self.range.end).await.map_err(|_| StorageError::Flash)?;
        self.next_at = self.range.start;
        for record in kept.iter().take(count).rev() {
            flash.write(self.next_at, record).await.map_err(|_| StorageError::Flash)?;
            self.next_at += RECORD_BYTES as u32;
        }
        Ok(())
    }
}

async fn read<F: NorFlash>(flash: &mut F, at: u32) -> Result<Record, StorageError> {
    let mut record = [0; RECORD_BYTES];
    flash.read(at, &mut record).await.map_err(|_| StorageError::Flash)?;
    Ok(record)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use embassy_futures::block_on;
    use embedded_storage_async::nor_flash::{ErrorType, ReadNorFlash};
    use std::vec;
    use std::vec::Vec;

    const SECTOR: usize = 4096;
    const RANGE: Range<u32> = 0..SECTOR as u32;

    struct Flash(Vec<u8>);

    impl ErrorType for Flash {
        type Error = core::convert::Infallible;
    }

    impl ReadNorFlash for Flash {
        const READ_SIZE: usize = 1;

        async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
            bytes.copy_from_slice(&self.0[offset as usize..][..bytes.len()]);
            Ok(())
        }

        fn capacity(&self) -> usize {
            SECTOR
        }
    }

    impl NorFlash for Flash {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = SECTOR;

        async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
            self.0[from as usize..to as usize].fill(ERASED);
            Ok(())
        }

        async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
            for (cell, byte) in self.0[offset as usize..].iter_mut().zip(bytes) {
                *cell &= byte;
            }
            Ok(())
        }
    }

    fn event(at_ms: u32) -> Event {
        let faults = Faults::OVER_SPEED.bits();
        let (speed_rad_s, worst_cycles, resolver_faults) = (41.0, 2000, 3);
        Event { number: 0, faults, at_ms, position: -5, speed_rad_s, worst_cycles, resolver_faults, restart: None }
    }

    #[test]
    fn a_restart_goes_through_a_record_and_one_of_a_later_release_is_none() {
        let place = 0xABCD;
        let restarts = [Restart::Watchdog, Restart::Panic(place), Restart::HardFault, Restart::ClockFailed];
        for restart in restarts.into_iter().chain([Restart::Interrupt(place)]) {
            let event = Event { restart: Some(restart), ..event(1) };
            assert_eq!(Event::decode(&event.encode()), Some(event));
        }
        assert_eq!((Restart::decode([0, 0, 0]), Restart::decode([6, 1, 2])), (None, None));
    }

    #[test]
    fn the_newest_come_first_and_a_full_sector_keeps_the_last_64() {
        let mut flash = Flash(vec![ERASED; SECTOR]);
        let mut log = block_on(EventLog::open(&mut flash, RANGE)).unwrap();
        assert_eq!(block_on(log.newest(&mut flash, 0)), Ok(None));
        for nth in 0..300 {
            block_on(log.append(&mut flash, &event(nth))).unwrap();
            if nth % 50 == 49 {
                // The drive was started again.
                log = block_on(EventLog::open(&mut flash, RANGE)).unwrap();
            }
            for back in 0..KEPT.min(nth as usize + 1) as u8 {
                let found = block_on(log.newest(&mut flash, back)).unwrap().unwrap();
                let number = nth - u32::from(back);
                assert_eq!(found, Event { number, ..event(number) });
            }
        }
    }

    #[test]
    fn a_drive_that_is_never_started_again_keeps_the_last_64_too() {
        let mut flash = Flash(vec![ERASED; SECTOR]);
        let mut log = block_on(EventLog::open(&mut flash, RANGE)).unwrap();
        let mut tidied = 0;
        for nth in 0..600 {
            block_on(log.append(&mut flash, &event(nth))).unwrap();
            // The fault is cleared.
            tidied += u32::from(log.is_full());
            block_on(log.make_room(&mut flash)).unwrap();
            for back in 0..KEPT.min(nth as usize + 1) as u8 {
                let found = block_on(log.newest(&mut flash, back)).unwrap().unwrap();
                assert_eq!(found.number, nth - u32::from(back));
            }
        }
        // 128 places: 64 more after each time.
        assert_eq!(tidied, 1 + (600 - 128) / 64);
    }

    #[test]
    fn a_torn_record_is_passed_over_and_a_sector_full_of_noise_is_made_usable() {
        let mut flash = Flash(vec![ERASED; SECTOR]);
        let mut log = block_on(EventLog::open(&mut flash, RANGE)).unwrap();
        block_on(log.append(&mut flash, &event(1))).unwrap();
        flash.0[RECORD_BYTES..RECORD_BYTES + 7].fill(0);
        let mut log = block_on(EventLog::open(&mut flash, RANGE)).unwrap();
        block_on(log.append(&mut flash, &event(2))).unwrap();
        let found = [0, 1, 2].map(|back| block_on(log.newest(&mut flash, back)).unwrap().map(|event| event.at_ms));
        assert_eq!(found, [Some(2), Some(1), None]);

        let mut noise = Flash((0..SECTOR).map(|at| (at * 37 % 251) as u8).collect());
        let mut log = block_on(EventLog::open(&mut noise, RANGE)).unwrap();
        block_on(log.append(&mut noise, &event(7))).unwrap();
        assert_eq!(block_on(log.newest(&mut noise, 0)).unwrap().unwrap().at_ms, 7);
    }
}
