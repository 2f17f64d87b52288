//! Whatever the bytes, a reader answers with what it read or with one message; it never panics.
//!
//! A bounded run with a fixed seed; the targets in `host-sim/fuzz` go on from here.

use std::fs;
use std::path::Path;

use analysis::simulate::{Reference, Setup, run};
use er_servo::{Config, Counts, Frame, Inputs, Timing};
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};
use recording::{Machine, Recording};

const SEED: u64 = 20_250_611;
const CASES: usize = 10_000;

const CSV: &str = "t_s,reference_rad,position_rad,torque_cmd_nm,field_cmd_kv_mm,mode,seq,fault,counts,note\n\
                   0,0.5,0,30,0,off,1,0,-5,\"a\"\n0.0005,0.5,1e-5,29.5,1.25,damper,2,0,7,b\n\
                   0.0010,0.5,2e-5,29,3,brake,4,1,8,\n";
const MACHINE: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\nresolution = 0\n\
                       [plant]\ninertia = 0.075\ncoulomb = 0.763\n[plant.er]\na = 0.07\nb = 0.47\n\
                       [controller]\nkp_nm_rad = 240\n\
                       [[effects]]\nid = \"cogging\"\namplitude_nm = 0.1\norder_per_rev = 7\nphase_rad = 0\n";

/// Bytes from nothing, or `valid` with up to eight places flipped, inserted, deleted or cut off.
fn hostile(random: &mut StdRng, valid: &[u8]) -> Vec<u8> {
    if random.random_ratio(1, 5) {
        let length = random.random_range(0..400);
        return (0..length).map(|_| random.random()).collect();
    }
    let mut bytes = valid.to_vec();
    for _ in 0..random.random_range(1..=8) {
        let at = random.random_range(0..=bytes.len());
        match random.random_range(0..5) {
            0 if at < bytes.len() => bytes[at] ^= 1 << random.random_range(0..8),
            1 => bytes.insert(at, random.random()),
            2 if at < bytes.len() => drop(bytes.remove(at)),
            3 if random.random_ratio(1, 4) => bytes.truncate(at),
            _ => {
                let from = random.random_range(0..=at);
                let again = bytes[from..at.min(from + 40)].to_vec();
                bytes.splice(at..at, again);
            }
        }
    }
    bytes
}

/// How many of the cases were refused; each message is one line and names the file.
fn refused(valid: &[u8], mut read: impl FnMut(&[u8]) -> Result<(), recording::Error>) -> usize {
    let mut random = StdRng::seed_from_u64(SEED);
    let mut refused = 0;
    for case in 0..CASES {
        let bytes = hostile(&mut random, valid);
        if let Err(error) = read(&bytes) {
            let message = error.to_string();
            assert!(message.lines().count() == 1 && message.contains("hostile"), "case {case}: {message:?}");
            refused += 1;
        }
    }
    refused
}

#[test]
fn machine_files() {
    let file = Path::new("hostile.toml");
    assert!(Machine::from_bytes(file, MACHINE.as_bytes()).is_ok());
    let refused = refused(MACHINE.as_bytes(), |bytes| Machine::from_bytes(file, bytes).map(drop));
    assert!(refused > CASES / 2 && refused < CASES, "{refused} of {CASES} refused");
}

#[test]
fn csv_recordings() {
    let file = Path::new("hostile.csv");
    assert!(Recording::from_csv_bytes(file, CSV.as_bytes(), None).is_ok());
    let refused = refused(CSV.as_bytes(), |bytes| Recording::from_csv_bytes(file, bytes, None).map(drop));
    assert!(refused > CASES / 2 && refused < CASES, "{refused} of {CASES} refused");
}

#[test]
fn parquet_recordings() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("hostile.parquet");
    Recording::from_csv_bytes(Path::new("a.csv"), CSV.as_bytes(), None).unwrap().write(&file).unwrap();
    let valid = fs::read(&file).unwrap();
    let refused = refused(&valid, |bytes| Recording::from_parquet_bytes(&file, bytes, None).map(drop));
    assert!(refused > CASES / 2 && refused < CASES, "{refused} of {CASES} refused");
}

#[test]
fn references() {
    let valid = b"t_s,reference_rad\n0,0\n0.0005,0.25\n0.0010,-1e-3\n0.5,3\n";
    let file = Path::new("hostile.csv");
    assert!(Reference::from_csv_bytes(file, valid).is_ok());
    let refused = refused(valid, |bytes| {
        let reference = Reference::from_csv_bytes(file, bytes)?;
        if let Ok(positions) = reference.positions(0.0005) {
            assert!(positions.take(10_000).count() > 0);
        }
        Ok(())
    });
    assert!(refused > CASES / 2 && refused < CASES, "{refused} of {CASES} refused");
}

#[test]
fn frames() {
    let rows = run(
        &Setup {
            model: plant::Model::paper(),
            config: Config::default(),
            disturbances: Vec::new(),
            sensor_noise_rad: 0.0,
            torque_noise_nm: 0.0,
            seed: 1,
        },
        [Counts(100)],
    );
    let outputs = rows.unwrap()[0].outputs;
    let frame = Frame { seq: 7, lost: 1, inputs: Inputs::default(), outputs, timing: Timing::default() };
    let valid = frame.encode();
    let mut random = StdRng::seed_from_u64(SEED);
    let mut decoded = 0;
    for _ in 0..CASES * 50 {
        let mut bytes = hostile(&mut random, &valid);
        if random.random() && bytes.len() == valid.len() {
            // With a check that matches, the values behind it are reached.
            bytes[0] = valid[0];
            bytes[1] = check(&bytes);
        }
        if let Ok(frame) = Frame::decode(&bytes) {
            assert_eq!(Frame::decode(&frame.encode()), Ok(frame));
            decoded += 1;
        }
    }
    assert!(decoded > CASES / 10, "{decoded} decoded");
}

/// CRC-8 of a frame, polynomial 0x07, over all bytes but itself.
fn check(bytes: &[u8]) -> u8 {
    let others = bytes.iter().enumerate().filter(|(at, _)| *at != 1).map(|(_, byte)| *byte);
    others.fold(0, |sum, byte| {
        (0..8).fold(sum ^ byte, |sum: u8, _| if sum & 0x80 == 0 { sum << 1 } else { sum << 1 ^ 0x07 })
    })
}
