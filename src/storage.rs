//! Parameters in flash, safe against power failing at any moment: after it the set is the old one or the new one.
//!
//! Two sectors are logs of records; a record holds a whole set, its number and a check, so that no mixture of two sets
//! can be read, and the valid one with the highest number is the stored set. A new one is written behind it, or, where
//! its sector is full, at the start of the other sector, which is erased before and holds older sets only. So nothing is
//! ever erased or written where the stored set stands, whatever a torn write or erase leaves behind.
//!
//! Own code, as the crate `sequential-storage` (8.0) does not promise as much with two sectors: an erase that is cut
//! short can leave the markers of a full sector over spoilt items, and its repair then erases the sector with the newest
//! item to repeat a migration.
//!
//! | bytes of a record | content |
//! |---|---|
//! | 0..4 | number, counted up with each save |
//! | 4..8 | CRC-32 of all other bytes |
//! | 8..10 | layout, 2 |
//! | 10..12 | count of values |
//! | 12.. | the values in the order of [`TABLE`], single precision |

use embedded_storage_async::nor_flash::NorFlash;

use crate::parameters::TABLE;
use crate::{Config, Params};

/// Layout of a record; another one is refused.
const VERSION: u16 = 2;
/// Room of a record; [`TABLE`] can grow to 61 values.
const RECORD_BYTES: usize = 256;
/// Before the values.
const HEAD_BYTES: usize = 12;
const ERASED: u8 = 0xFF;

const CRC: crc::Crc<u32, crc::NoTable> = crc::Crc::<u32, crc::NoTable>::new(&crc::CRC_32_ISO_HDLC);

const _: () = assert!(HEAD_BYTES + 4 * TABLE.len() <= RECORD_BYTES);

/// Why parameters could not be saved or loaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StorageError {
    /// The flash could not be read, written or erased, or does not hold what was written.
    Flash,
    /// Nothing was ever stored: every byte is erased.
    Empty,
    /// What is stored is damaged, of another version, or not for this image.
    Unusable,
}

type Record = [u8; RECORD_BYTES];

/// The stored set: its number and where it stands.
#[derive(Debug, Clone, Copy)]
struct Newest {
    number: u32,
    at: u32,
}

/// Writes the set and reads it back. `range` is two sectors.
///
/// # Errors
///
/// [`StorageError::Flash`]; the set that was stored before is then still the one that is loaded.
pub async fn save<F: NorFlash>(
    mut flash: F,
    range: core::ops::Range<u32>,
    config: &Config,
) -> Result<(), StorageError> {
    let newest = newest(&mut flash, &range).await?;
    let at = free_place(&mut flash, &range, newest).await?;
    let record = encode(newest.map_or(0, |newest| newest.number.wrapping_add(1)), config);
    flash.write(at, &record).await.map_err(|_| StorageError::Flash)?;
    if read(&mut flash, at).await? == record { Ok(()) } else { Err(StorageError::Flash) }
}

/// Reads the newest set that this image can read, where [`load`] finds the newest [`StorageError::Unusable`]: after a downgrade,
/// the set that was stored before the newer image saved its own, unless that was erased to make room since.
///
/// # Errors
///
/// As [`load`].
pub async fn load_older<F: NorFlash>(mut flash: F, range: core::ops::Range<u32>) -> Result<Config, StorageError> {
    let mut best: Option<(u32, Config)> = None;
    for at in range.step_by(RECORD_BYTES) {
        let record = read(&mut flash, at).await?;
        let number = word(&record, 0);
        if !is_whole(&record) || best.is_some_and(|(newest, _)| number <= newest) {
            continue;
        }
        if let Ok(config) = decode(&record) {
            best = Some((number, config));
        }
    }
    best.map(|(_, config)| config).ok_or(StorageError::Unusable)
}

/// Reads the newest whole set and checks every value.
///
/// # Errors
///
/// See [`StorageError`].
pub async fn load<F: NorFlash>(mut flash: F, range: core::ops::Range<u32>) -> Result<Config, StorageError> {
    let Some(newest) = newest(&mut flash, &range).await? else {
        let blank = is_erased(&mut flash, &range).await?;
        return Err(if blank { StorageError::Empty } else { StorageError::Unusable });
    };
    decode(&read(&mut flash, newest.at).await?)
}

/// The place for the next record, erased.
async fn free_place<F: NorFlash>(
    flash: &mut F,
    range: &core::ops::Range<u32>,
    newest: Option<Newest>,
) -> Result<u32, StorageError> {
    let sector_bytes = F::ERASE_SIZE as u32;
    let middle = range.start + sector_bytes;
    let mut other = range.start;
    if let Some(newest) = newest {
        let end = if newest.at < middle { middle } else { range.end };
        let mut at = newest.at + RECORD_BYTES as u32;
        while at < end {
            // A record that a power failure has torn is passed over.
            if read(flash, at).await?.iter().all(|byte| *byte == ERASED) {
                return Ok(at);
            }
            at += RECORD_BYTES as u32;
        }
        other = if newest.at < middle { middle } else { range.start };
    }
    // Erased even if it looks erased: after an erase that was cut short it may only just look so.
    flash.erase(other, other + sector_bytes).await.map_err(|_| StorageError::Flash)?;
    Ok(other)
}

async fn newest<F: NorFlash>(flash: &mut F, range: &core::ops::Range<u32>) -> Result<Option<Newest>, StorageError> {
    let mut newest: Option<Newest> = None;
    for at in range.clone().step_by(RECORD_BYTES) {
        let record = read(flash, at).await?;
        if is_whole(&record) {
            let number = word(&record, 0);
            if newest.is_none_or(|newest| number > newest.number) {
                newest = Some(Newest { number, at });
            }
        }
    }
    Ok(newest)
}

async fn is_erased<F: NorFlash>(flash: &mut F, range: &core::ops::Range<u32>) -> Result<bool, StorageError> {
    for at in range.clone().step_by(RECORD_BYTES) {
        if read(flash, at).await?.iter().any(|byte| *byte != ERASED) {
            return Ok(false);
        }
    }
    Ok(true)
}

async fn read<F: NorFlash>(flash: &mut F, at: u32) -> Result<Record, StorageError> {
    let mut record = [0; RECORD_BYTES];
    flash.read(at, &mut record).await.map_err(|_| StorageError::Flash)?;
    Ok(record)
}

fn encode(number: u32, config: &Config) -> Record {
    let mut record = [ERASED; RECORD_BYTES];
    record[..4].copy_from_slice(&number.to_le_bytes());
    record[8..10].copy_from_slice(&VERSION.to_le_bytes());
    record[10..12].copy_from_slice(&(TABLE.len() as u16).to_le_bytes());
    for (parameter, place) in TABLE.iter().zip(record[HEAD_BYTES..].chunks_exact_mut(4)) {
        place.copy_from_slice(&(parameter.get)(config).to_le_bytes());
    }
    let check = check(&record);
    record[4..8].copy_from_slice(&check.to_le_bytes());
    record
}

fn check(record: &Record) -> u32 {
    let mut digest = CRC.digest();
    digest.update(&record[..4]);
    digest.update(&record[8..]);
    digest.finalize()
}

/// An erased record is none: the check of all ones is not all ones.
fn is_whole(record: &Record) -> bool {
    word(record, 4) == check(record)
}

fn word(record: &Record, at: usize) -> u32 {
    u32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
}

fn decode(record: &Record) -> Result<Config, StorageError> {
    let count = usize::from(u16::from_le_bytes([record[10], record[11]]));
    // A set from before a parameter was added keeps that one's default.
    if u16::from_le_bytes([record[8], record[9]]) != VERSION || count > TABLE.len() {
        return Err(StorageError::Unusable);
    }
    let mut config = Config::default();
    for (parameter, value) in TABLE.iter().take(count).zip(record[HEAD_BYTES..].as_chunks::<4>().0) {
        (parameter.set)(&mut config, f32::from_le_bytes(*value));
    }
    // Whoever forced it has seen the margins.
    Params::for_image(&config, true).map(|_| config).map_err(|_| StorageError::Unusable)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::*;
    use embassy_futures::block_on;
    use embedded_storage_async::nor_flash::{ErrorType, NorFlashError, NorFlashErrorKind, ReadNorFlash};
    use std::vec;
    use std::vec::Vec;

    const PAGE: usize = 1024;
    const RANGE: core::ops::Range<u32> = 0..2 * PAGE as u32;

    /// Flash of two pages whose power can fail after any number of programmed bytes or erased blocks of 64 bytes.
    struct Flash<'a> {
        bytes: &'a mut Vec<u8>,
        power: u32,
    }

    #[derive(Debug)]
    struct PowerLost;

    impl NorFlashError for PowerLost {
        fn kind(&self) -> NorFlashErrorKind {
            NorFlashErrorKind::Other
        }
    }

    impl ErrorType for Flash<'_> {
        type Error = PowerLost;
    }

    impl Flash<'_> {
        fn spend(&mut self) -> Result<(), PowerLost> {
            self.power = self.power.checked_sub(1).ok_or(PowerLost)?;
            Ok(())
        }
    }

    impl ReadNorFlash for Flash<'_> {
        const READ_SIZE: usize = 1;

        async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerLost> {
            bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
            Ok(())
        }

        fn capacity(&self) -> usize {
            self.bytes.len()
        }
    }

    impl NorFlash for Flash<'_> {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = PAGE;

        async fn erase(&mut self, from: u32, to: u32) -> Result<(), PowerLost> {
            for block in self.bytes[from as usize..to as usize].chunks_mut(64) {
                self.power = self.power.checked_sub(1).ok_or(PowerLost)?;
                block.fill(0xFF);
            }
            Ok(())
        }

        async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerLost> {
            for (at, byte) in bytes.iter().enumerate() {
                self.spend()?;
                self.bytes[offset as usize + at] &= byte;
            }
            Ok(())
        }
    }

    fn set(kp_nm_rad: f32) -> Config {
        Config { kp_nm_rad, ..Config::default() }
    }

    fn flash(bytes: &mut Vec<u8>, power: u32) -> Flash<'_> {
        Flash { bytes, power }
    }

    #[test]
    fn empty_flash_and_flash_full_of_garbage_give_no_set() {
        assert_eq!(block_on(load(flash(&mut vec![0xFF; 2 * PAGE], u32::MAX), RANGE)), Err(StorageError::Empty));
        let mut garbage: Vec<u8> = (0..2 * PAGE).map(|at| (at * 37 % 251) as u8).collect();
        assert_eq!(block_on(load(flash(&mut garbage, u32::MAX), RANGE)), Err(StorageError::Unusable));
        let mut one_bit = vec![0xFF; 2 * PAGE];
        one_bit[700] = 0xFE;
        assert_eq!(block_on(load(flash(&mut one_bit, u32::MAX), RANGE)), Err(StorageError::Unusable));
        // And a set can be saved over it.
        block_on(save(flash(&mut garbage, u32::MAX), RANGE, &set(300.0))).unwrap();
        assert_eq!(block_on(load(flash(&mut garbage, u32::MAX), RANGE)), Ok(set(300.0)));
    }

    #[test]
    fn another_version_or_a_value_out_of_range_is_refused() {
        let record = encode(7, &set(300.0));
        assert_eq!(decode(&record), Ok(set(300.0)));
        let mut other = record;
        other[8] = 1;
        assert_eq!(decode(&other), Err(StorageError::Unusable));
        let mut out_of_range = record;
        out_of_range[HEAD_BYTES..HEAD_BYTES + 4].copy_from_slice(&0_f32.to_le_bytes());
        assert_eq!(decode(&out_of_range), Err(StorageError::Unusable), "a period of 0");
        // A set from before any parameter was added.
        let mut older = record;
        older[10..12].copy_from_slice(&0_u16.to_le_bytes());
        assert_eq!(decode(&older), Ok(Config::default()));
        assert!(!is_whole(&[ERASED; RECORD_BYTES]) && !is_whole(&[0; RECORD_BYTES]));
    }

    #[test]
    fn a_downgrade_rolls_back_to_the_newest_set_that_it_can_read() {
        let mut bytes = vec![0xFF; 2 * PAGE];
        for kp_nm_rad in [240.0, 250.0] {
            block_on(save(flash(&mut bytes, u32::MAX), RANGE, &set(kp_nm_rad))).unwrap();
        }
        // A newer image knows more parameters, and another layout.
        let mut newer = encode(2, &set(260.0));
        newer[10..12].copy_from_slice(&(TABLE.len() as u16 + 1).to_le_bytes());
        let mut other = encode(3, &set(270.0));
        other[8] += 1;
        for (nth, mut record) in [newer, other].into_iter().enumerate() {
            let check = check(&record);
            record[4..8].copy_from_slice(&check.to_le_bytes());
            bytes[(2 + nth) * RECORD_BYTES..][..RECORD_BYTES].copy_from_slice(&record);
        }
        assert_eq!(block_on(load(flash(&mut bytes, u32::MAX), RANGE)), Err(StorageError::Unusable));
        assert_eq!(block_on(load_older(flash(&mut bytes, u32::MAX), RANGE)), Ok(set(250.0)));
        // What the older image saves then is the newest for both.
        block_on(save(flash(&mut bytes, u32::MAX), RANGE, &set(280.0))).unwrap();
        assert_eq!(block_on(load(flash(&mut bytes, u32::MAX), RANGE)), Ok(set(280.0)));
        assert_eq!(block_on(load_older(flash(&mut vec![0; 2 * PAGE], u32::MAX), RANGE)), Err(StorageError::Unusable));
    }

    #[test]
    fn power_may_fail_at_any_byte_of_any_save() {
        // Thirty saves fill both pages more than once, so that every kind of page change is cut at every byte.
        let mut bytes = vec![0xFF; 2 * PAGE];
        block_on(save(flash(&mut bytes, u32::MAX), RANGE, &set(240.0))).unwrap();
        let (mut cuts, mut old_sets, mut new_sets) = (0, 0, 0);
        for nth in 1..=30_u16 {
            let (old, new) = (set(240.0 + f32::from(nth - 1)), set(240.0 + f32::from(nth)));
            for power in 0.. {
                let mut cut = bytes.clone();
                if block_on(save(flash(&mut cut, power), RANGE, &new)).is_ok() {
                    break;
                }
                cuts += 1;
                let loaded = block_on(load(flash(&mut cut, u32::MAX), RANGE));
                if loaded == Ok(new) {
                    new_sets += 1
                } else {
                    old_sets += 1
                }
                assert!(loaded == Ok(old) || loaded == Ok(new), "save {nth} cut at {power}: {loaded:?}");
                // And the next save works.
                block_on(save(flash(&mut cut, u32::MAX), RANGE, &new)).unwrap();
                assert_eq!(block_on(load(flash(&mut cut, u32::MAX), RANGE)), Ok(new));
            }
            block_on(save(flash(&mut bytes, u32::MAX), RANGE, &new)).unwrap();
        }
        assert!(cuts > 2000 && old_sets > 0 && new_sets > 0, "{cuts} cuts: {old_sets} old, {new_sets} new");
    }
}
