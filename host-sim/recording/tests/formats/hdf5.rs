//! HDF5 and MATLAB 7.3 of other programs: vectors, matrices, tables, packed and not; a bad file is a message.
//!
//! The files are written by h5py: `data/make_hdf5.py`.

use std::fs;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use recording::{AxisKind, Column, Error, Given, Table, guess};

const FILES: [&str; 3] = ["classic.h5", "latest.h5", "matlab73.mat"];
const ROWS: usize = 60;

fn data(name: &str) -> PathBuf {
    Path::new("tests/data").join(name)
}

fn read(bytes: &[u8]) -> Result<Table, String> {
    Table::from_bytes(Path::new("a.h5"), bytes).map_err(|error: Error| error.to_string())
}

fn column<'a>(table: &'a Table, name: &str) -> &'a [f64] {
    table.column(name).unwrap_or_else(|| panic!("{name} is not there: {:?}", table.numbers)).1
}

fn t_s(row: usize) -> f64 {
    0.001 * row as f64
}

fn angle_deg(row: usize) -> f64 {
    30.0 * (5.0 * t_s(row)).sin()
}

/// Whether a column holds these numbers, to the digits of a single where it was one.
fn holds(table: &Table, name: &str, value: impl Fn(usize) -> f64) {
    let values = column(table, name);
    assert_eq!(values.len(), ROWS, "{name}");
    for (row, found) in values.iter().enumerate() {
        assert!((found - value(row)).abs() < 1e-6, "{name}, row {row}: {found} in place of {}", value(row));
    }
}

#[test]
fn vectors_matrices_and_tables_of_both_formats_are_columns() {
    for name in ["classic.h5", "latest.h5"] {
        let table = Table::read(&data(name)).unwrap();
        holds(&table, "t", t_s);
        holds(&table, "motor.angle_deg", angle_deg);
        holds(&table, "motor.current", |row| (5.0 * t_s(row)).cos());
        holds(&table, "motor.counts", |row| (1000.0 * angle_deg(row)).round());
        holds(&table, "motor.enabled", |row| f64::from(u8::from(row > 10)));
        holds(&table, "motor.pair[1]", angle_deg);
        holds(&table, "motor.pair[2]", t_s);
        holds(&table, "table.t", t_s);
        holds(&table, "table.torque", |row| (5.0 * t_s(row)).cos());
        assert_eq!(table.numbers.len(), 9, "no text: {:?}", table.numbers);
    }
}

#[test]
fn matlab_7_3_has_its_vectors_and_structures_and_nothing_of_its_own() {
    let table = Table::read(&data("matlab73.mat")).unwrap();
    holds(&table, "t", t_s);
    holds(&table, "run.angle_deg", angle_deg);
    holds(&table, "run.current", |row| (5.0 * t_s(row)).cos());
    holds(&table, "run.log[2]", t_s);
    assert_eq!(table.numbers.len(), 6, "no text, no object, nothing empty: {:?}", table.numbers);
    let (axis, guesses) = guess(&table, Given::default()).unwrap();
    let names: Vec<_> = guesses.iter().map(|guess| (guess.mapped.column, guess.mapped.name.as_str())).collect();
    assert_eq!(axis, AxisKind::Rotary);
    assert!(names.contains(&(Column::Time, "t")) && names.contains(&(Column::Position, "run.angle_deg")), "{names:?}");
}

#[test]
fn a_file_that_is_cut_short_is_refused() {
    for name in FILES {
        let whole = fs::read(data(name)).unwrap();
        for length in 14..whole.len() {
            let error = read(&whole[..length]).expect_err("half a log is none");
            assert!(error.contains("or was cut short") || error.contains("not of a known format"), "{length}: {error}");
        }
    }
}

#[test]
fn a_file_with_a_bent_byte_is_read_or_refused() {
    for name in FILES {
        let whole = fs::read(data(name)).unwrap();
        for place in 14..whole.len() {
            for with in [0x01, 0xa5, 0xff] {
                let mut bent = whole.clone();
                bent[place] ^= with;
                if let Ok(table) = read(&bent) {
                    assert!(!table.numbers.is_empty(), "{name}, byte {place}");
                }
            }
        }
    }
}

proptest! {
    /// Several bytes at once, where one alone is found by a sum.
    #[test]
    fn a_file_with_many_bent_bytes_is_read_or_refused(
        file in 0..FILES.len(),
        bends in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..40),
    ) {
        let mut bytes = fs::read(data(FILES[file])).unwrap();
        for (place, with) in bends {
            let place = place.index(bytes.len() - 14) + 14;
            bytes[place] = with;
        }
        drop(read(&bytes));
    }
}

#[test]
fn a_file_without_numbers_says_what_to_do() {
    let whole = fs::read(data("matlab73.mat")).unwrap();
    let mut bytes = whole;
    // With every class another, nothing is a number.
    for (from, to) in [(&b"double"[..], &b"tabled"[..]), (b"single", b"tabled"), (b"logical", b"tabledd")] {
        for place in 0..bytes.len() - from.len() {
            if bytes[place..].starts_with(from) {
                bytes[place..place + to.len()].copy_from_slice(to);
            }
        }
    }
    let error = read(&bytes).unwrap_err();
    assert!(error.contains("holds no vectors of numbers; ") && error.contains("table2struct"), "{error}");
}
