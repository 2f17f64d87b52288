//! Parameters in flash, safe against power failing at any moment: after it the set is the old one or the new one.
//!
//! One item holds the whole set, so that no mixture of two sets can be read. `sequential-storage` writes it behind the
//! last one and marks it valid by a check; a page is erased only when the newest item stands in the other.

use embedded_storage_async::nor_flash::NorFlash;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};

use crate::parameters::TABLE;
use crate::{Config, Params};

/// Layout of the stored set; another one is refused.
const VERSION: u16 = 1;
/// The one key.
const KEY: u8 = 1;
/// Version, then one single-precision value a parameter.
const ITEM_BYTES: usize = 2 + 4 * MAX_PARAMETERS;
/// More than [`TABLE`] has, so that it can grow.
const MAX_PARAMETERS: usize = 40;
/// The item, its key, rounded up to the flash's word.
const BUFFER_BYTES: usize = (ITEM_BYTES + 1).next_multiple_of(32);

type NoCache = Cache<Uncached, Uncached, Uncached, u8>;

/// Why parameters could not be saved or loaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StorageError {
    /// The flash could not be read, written or erased, or does not hold what was written.
    Flash,
    /// Nothing is stored.
    Empty,
    /// What is stored is of another version, or fails its checks.
    Unusable,
}

/// Writes the set and reads it back.
///
/// # Errors
///
/// [`StorageError::Flash`]; the set that was stored before is then still the one that is loaded.
pub async fn save<F: NorFlash>(flash: F, range: core::ops::Range<u32>, config: &Config) -> Result<(), StorageError> {
    let mut item = [0; ITEM_BYTES];
    let (version, values) = item.split_at_mut(2);
    version.copy_from_slice(&VERSION.to_le_bytes());
    for (parameter, place) in TABLE.iter().zip(values.chunks_exact_mut(4)) {
        place.copy_from_slice(&(parameter.get)(config).to_le_bytes());
    }
    let item = item.get(..2 + 4 * TABLE.len()).ok_or(StorageError::Unusable)?;
    let mut storage = open(flash, range)?;
    let mut buffer = [0; BUFFER_BYTES];
    storage.store_item(&mut buffer, &KEY, &item).await.map_err(|_| StorageError::Flash)?;
    match storage.fetch_item::<&[u8]>(&mut buffer, &KEY).await {
        Ok(Some(stored)) if stored == item => Ok(()),
        _ => Err(StorageError::Flash),
    }
}

/// Reads the newest whole set and checks every value.
///
/// # Errors
///
/// See [`StorageError`].
pub async fn load<F: NorFlash>(flash: F, range: core::ops::Range<u32>) -> Result<Config, StorageError> {
    let mut storage = open(flash, range)?;
    let mut buffer = [0; BUFFER_BYTES];
    let item = storage.fetch_item::<&[u8]>(&mut buffer, &KEY).await.map_err(|_| StorageError::Flash)?;
    decode(item.ok_or(StorageError::Empty)?)
}

fn open<F: NorFlash>(flash: F, range: core::ops::Range<u32>) -> Result<MapStorage<u8, F, NoCache>, StorageError> {
    let config = MapConfig::try_new(range).map_err(|_| StorageError::Flash)?;
    Ok(MapStorage::new(flash, config, Cache::new_uncached()))
}

fn decode(item: &[u8]) -> Result<Config, StorageError> {
    let (version, values) = item.split_first_chunk::<2>().ok_or(StorageError::Unusable)?;
    // A set from before a parameter was added keeps that one's default.
    if u16::from_le_bytes(*version) != VERSION || values.len() > 4 * TABLE.len() {
        return Err(StorageError::Unusable);
    }
    let mut config = Config::default();
    for (parameter, value) in TABLE.iter().zip(values.as_chunks::<4>().0) {
        (parameter.set)(&mut config, f32::from_le_bytes(*value));
    }
    Params::new(&config).map(|_| config).map_err(|_| StorageError::Unusable)
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
        assert!(block_on(load(flash(&mut garbage, u32::MAX), RANGE)).is_err());
        // And a set can be saved over it.
        block_on(save(flash(&mut garbage, u32::MAX), RANGE, &set(300.0))).unwrap();
        assert_eq!(block_on(load(flash(&mut garbage, u32::MAX), RANGE)), Ok(set(300.0)));
    }

    #[test]
    fn another_version_or_a_value_out_of_range_is_refused() {
        let mut item = vec![0; 2 + 4 * TABLE.len()];
        assert_eq!(decode(&item), Err(StorageError::Unusable));
        item[..2].copy_from_slice(&VERSION.to_le_bytes());
        assert_eq!(decode(&item), Err(StorageError::Unusable), "a period of 0 is out of range");
        assert_eq!(decode(&item[..2]), Ok(Config::default()));
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
