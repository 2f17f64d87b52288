//! Power failing while the unmodified image saves its parameters to the emulated flash: the old set or the new one is there
//! afterwards, never a broken one.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};

use board::bench::Firmware;
use board::flash::{Array, Change, SECTOR_BYTES, Shared};
use board::world::World;
use common::flash::OnHost;
use common::{firmware, ms};
use embassy_futures::block_on;
use er_servo::link::{Answer, Command, ParameterSource, Refusal};
use er_servo::parameters::TABLE;
use er_servo::storage::StorageError;
use er_servo::{Config, Faults, storage};
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

const SEED: u64 = 20_260_402;
const LENGTH: usize = 2 * SECTOR_BYTES;
/// The chips are up and the link answers after this.
const UP_MS: f64 = 55.0;
/// One in so many of the states that a cut can leave is booted; a prime, to fall on every byte of a word.
const BOOTED: usize = 19;

/// Two parameters that a save changes together, so that a mixture of two sets would show.
type Set = (f32, f32);

fn index(name: &str) -> u8 {
    TABLE.iter().position(|parameter| parameter.name == name).unwrap() as u8
}

/// Boots the image on `bytes`, sends it `commands`, and gives the answers and the flash.
fn run(firmware: &Firmware, bytes: Vec<u8>, commands: &[Command], end_ms: f64) -> (Vec<Answer>, Array) {
    let mut world: World = common::world(firmware, end_ms);
    let flash = Shared::new(Array::holding(bytes));
    world.flash = flash.clone();
    for (nth, command) in (0_u32..).zip(commands) {
        world.link.at(ms(UP_MS + 1.5 * f64::from(nth)), *command);
    }
    let run = firmware.run(world).unwrap();
    assert!(run.session.resets().is_empty(), "the watchdog waits for an erase: {:?}", run.session.resets());
    let answers = run.driver.link.replies.iter().map(|(_, reply)| reply.answer);
    let answers = answers.filter(|answer| !matches!(answer, Answer::Hello { .. })).collect();
    let array = flash.lock().clone();
    (answers, array)
}

/// The set with which the image comes up.
fn comes_up_with(firmware: &Firmware, bytes: Vec<u8>) -> Set {
    let commands = ["kp_nm_rad", "kd_nm_s_rad"].map(|name| Command::ReadParameter { index: index(name) });
    let (answers, _) = run(firmware, bytes, &commands, UP_MS + 7.0);
    let [Answer::Parameter { value: kp }, Answer::Parameter { value: kd }] = answers.as_slice() else {
        panic!("{answers:?}");
    };
    (*kp, *kd)
}

/// The image saves a set; ends once it has said so.
fn save(firmware: &Firmware, bytes: Vec<u8>, set: Set, end_ms: f64) -> Array {
    let commands = [
        Command::WriteParameter { index: index("kp_nm_rad"), value: set.0 },
        Command::WriteParameter { index: index("kd_nm_s_rad"), value: set.1 },
        // Whatever margins such gains have.
        Command::Apply { force: true },
        Command::Save,
    ];
    let (answers, array) = run(firmware, bytes, &commands, end_ms);
    assert_eq!(answers, [Answer::Done; 4], "{set:?}");
    assert_eq!(array.refused, 0, "every store and erase keeps the rules of the flash interface");
    array
}

/// A flash with both sectors written, into which exactly one more set fits before a sector has to be erased.
fn nearly_full(set: Set) -> Vec<u8> {
    let config = Config { kp_nm_rad: set.0, kd_nm_s_rad: set.1, ..Config::default() };
    let mut history = vec![vec![0xFF; LENGTH]];
    loop {
        let mut bytes = history.last().unwrap().clone();
        block_on(storage::save(OnHost(&mut bytes), 0..LENGTH as u32, &config)).unwrap();
        let erased = bytes.iter().zip(history.last().unwrap()).any(|(now, before)| now & !before != 0);
        if erased {
            return history.swap_remove(history.len() - 2);
        }
        history.push(bytes);
    }
}

/// Everything the flash can hold when power fails during `changes`: between any two of them, and in the middle of one,
/// which leaves some bits of a byte programmed, or some bytes of a sector erased.
fn cuts(before: &[u8], changes: &[Change], rng: &mut StdRng) -> BTreeSet<Vec<u8>> {
    let mut now = before.to_vec();
    let mut found = BTreeSet::from([now.clone()]);
    for change in changes {
        let mut half = now.clone();
        match *change {
            Change::Program { at, byte } => half[at] &= byte | rng.random::<u8>(),
            Change::Erase { from } => {
                half[from..from + SECTOR_BYTES].iter_mut().for_each(|cell| *cell |= rng.random::<u8>());
            }
        }
        found.insert(half);
        change.apply(&mut now);
        found.insert(now.clone());
    }
    found
}

/// Which set the storage code finds in an array, on the host.
fn loaded_on_host(bytes: &[u8]) -> Result<Set, StorageError> {
    let config = block_on(storage::load(OnHost(&mut bytes.to_vec()), 0..LENGTH as u32))?;
    Ok((config.kp_nm_rad, config.kd_nm_s_rad))
}

/// Boots the image on each of `arrays`; it must come up with the set that the host finds there.
fn boot_all(firmware: &Firmware, arrays: &[&Vec<u8>]) {
    let next = AtomicUsize::new(0);
    let worker = || {
        while let Some(bytes) = arrays.get(next.fetch_add(1, Ordering::Relaxed)) {
            assert_eq!(Ok(comes_up_with(firmware, bytes.to_vec())), loaded_on_host(bytes));
        }
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..2).map(|_| scope.spawn(worker)).collect();
        workers.into_iter().for_each(|worker| worker.join().unwrap());
    });
}

#[test]
fn a_saved_set_is_there_after_a_restart() {
    let firmware = firmware();
    let defaults = Config::default();
    let empty = vec![0xFF; LENGTH];
    assert_eq!(comes_up_with(&firmware, empty.clone()), (defaults.kp_nm_rad, defaults.kd_nm_s_rad));
    let array = save(&firmware, empty, (250.0, 7.5), 700.0);
    assert_eq!(comes_up_with(&firmware, array.bytes), (250.0, 7.5));
    // What is no set at all gives the built-in one in the fault state, and can be saved over.
    let array = save(&firmware, vec![0; LENGTH], (251.0, 7.25), 700.0);
    assert_eq!(comes_up_with(&firmware, array.bytes), (251.0, 7.25));
}

/// Bytes of a record of parameters, and what of it stands where, as the library's table has it.
const RECORD_BYTES: usize = 256;
const NUMBER: usize = 0;
const CHECK: std::ops::Range<usize> = 4..8;
const COUNT: usize = 10;

/// Behind the only record in flash, what a newer image has saved: it knows one parameter more.
fn save_by_a_newer_image(bytes: &mut [u8]) {
    let (sound, rest) = bytes.split_at_mut(RECORD_BYTES);
    let record = &mut rest[..RECORD_BYTES];
    record.copy_from_slice(sound);
    record[NUMBER] += 1;
    record[COUNT] += 1;
    let mut digest = CRC.digest();
    digest.update(&record[..CHECK.start]);
    digest.update(&record[CHECK.end..]);
    record[CHECK].copy_from_slice(&digest.finalize().to_le_bytes());
}

const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

#[test]
fn a_downgrade_comes_up_in_fault_with_the_set_before_and_runs_once_that_is_cleared() {
    let firmware = firmware();
    let mut bytes = vec![0xFF; LENGTH];
    let older = Config { kp_nm_rad: 250.0, ..Config::default() };
    block_on(storage::save(OnHost(&mut bytes), 0..LENGTH as u32, &older)).unwrap();
    save_by_a_newer_image(&mut bytes);
    assert_eq!(loaded_on_host(&bytes), Err(StorageError::Unusable), "this release does not know it");

    let mut world = common::world(&firmware, 170.0);
    world.flash = Shared::new(Array::holding(bytes));
    world.link.at(ms(80.0), Command::Status);
    world.link.at(ms(85.0), Command::ReadParameter { index: index("kp_nm_rad") });
    world.link.at(ms(90.0), common::ENABLE);
    world.link.at(ms(95.0), Command::ClearFault);
    world.link.at(ms(160.0), Command::Status);
    let run = firmware.run(world).unwrap();
    let answers: Vec<Answer> = run.driver.link.replies.iter().skip(1).map(|(_, reply)| reply.answer).collect();
    let [Answer::Status(before), kp, enabled, cleared, Answer::Status(after)] = answers.as_slice() else {
        panic!("{answers:?}");
    };
    assert_eq!((before.state, before.faults), (3, Faults::PARAMETERS.bits()));
    assert_eq!(before.parameters, ParameterSource::RolledBack);
    assert_eq!(*kp, Answer::Parameter { value: 250.0 });
    assert_eq!((*enabled, *cleared), (Answer::Refused(Refusal::Fault), Answer::Done));
    assert_eq!((after.state, after.faults, after.parameters), (1, 0, ParameterSource::RolledBack));
}

#[test]
fn a_set_that_was_forced_says_so_after_a_restart_too() {
    let firmware = firmware();
    let forced = Config { kd_nm_s_rad: 0.0, ..Config::default() };
    for (config, source) in [(Config::default(), ParameterSource::Flash), (forced, ParameterSource::StoredForced)] {
        let mut bytes = vec![0xFF; LENGTH];
        block_on(storage::save(OnHost(&mut bytes), 0..LENGTH as u32, &config)).unwrap();
        let mut world = common::world(&firmware, 85.0);
        world.flash = Shared::new(Array::holding(bytes));
        world.link.at(ms(80.0), Command::Status);
        let run = firmware.run(world).unwrap();
        assert_eq!(run.driver.link.status().unwrap().parameters, source);
        let told = common::events(&common::log(&run)).iter().any(|event| event.contains("parameters forced"));
        assert_eq!(told, source == ParameterSource::StoredForced);
    }
}

#[test]
fn power_may_fail_at_any_moment_of_a_save() {
    let firmware = firmware();
    let mut rng = StdRng::seed_from_u64(SEED);
    let sets: [Set; 4] = [(300.0, 8.0), (301.0, 8.25), (302.0, 8.5), (303.0, 8.75)];
    let mut bytes = nearly_full(sets[0]);
    let mut erased = 0;
    // The save that fills the sector, the one that changes sectors and erases, the one after.
    for pair in sets.windows(2) {
        let (old, new) = (pair[0], pair[1]);
        let saved = save(&firmware, bytes.clone(), new, 700.0);
        erased += saved.changes.iter().filter(|change| matches!(change, Change::Erase { .. })).count();
        let arrays: Vec<Vec<u8>> = cuts(&bytes, &saved.changes, &mut rng).into_iter().collect();
        // Every state by the storage code on the host; of the image's own boots, half a second each, one in BOOTED.
        let news = arrays.iter().filter(|bytes| loaded_on_host(bytes) == Ok(new)).count();
        let olds = arrays.iter().filter(|bytes| loaded_on_host(bytes) == Ok(old)).count();
        assert_eq!(olds + news, arrays.len(), "neither the old nor the new set");
        let booted: Vec<&Vec<u8>> = arrays.iter().step_by(BOOTED).collect();
        boot_all(&firmware, &booted);
        println!(
            "{} changes, {} states of the flash: {olds} old set, {news} new; {} of them booted",
            saved.changes.len(),
            arrays.len(),
            booted.len()
        );
        assert!(olds > 0 && news > 0);
        // The next save works, whatever the failed one has left.
        let after = save(&firmware, booted[booted.len() / 2].clone(), (444.0, 4.5), 700.0);
        assert_eq!(comes_up_with(&firmware, after.bytes), (444.0, 4.5));
        bytes = saved.bytes;
    }
    assert!(erased > 0, "no save changed sectors");
}
