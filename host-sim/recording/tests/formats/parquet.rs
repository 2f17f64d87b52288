//! Parquet of other programs, packed in each way that they do: the same values, or a message that says what to do.
//!
//! The files are written by polars and pyarrow: `data/make_parquet.py`.

use std::fs;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use recording::{Recording, Table};

/// What is read, the default of polars first.
const PACKED: [&str; 5] = ["polars", "snappy", "gzip", "lz4", "zstd"];

fn data(name: &str) -> PathBuf {
    Path::new("tests/data").join(format!("{name}.parquet"))
}

#[test]
fn every_packing_holds_the_same_values() {
    let plain = Table::read(&data("none")).unwrap();
    assert_eq!(plain.numbers.len(), 4);
    assert_eq!(plain.others, ["note"]);
    let (_, position) = plain.column("position_rad").unwrap();
    assert!(position.len() == 200 && position.iter().enumerate().all(|(row, at)| *at == (0.005 * row as f64).sin()));
    let recording = Recording::read(&data("none"), None).unwrap();
    for packing in PACKED {
        assert_eq!(Table::read(&data(packing)).unwrap(), plain, "{packing}");
        let read = Recording::read(&data(packing), None).unwrap();
        assert_eq!(Recording { name: recording.name.clone(), ..read }, recording, "{packing}");
    }
}

#[test]
fn a_null_matters_only_in_a_column_of_the_recording() {
    let [whole, nulls] = ["none", "nulls"].map(|name| Recording::read(&data(name), None).unwrap());
    assert_eq!((nulls.t_s, nulls.position, nulls.effort_cmd), (whole.t_s, whole.position, whole.effort_cmd));
}

#[test]
fn a_packing_that_is_not_read_is_named_with_what_to_do() {
    let error = Table::read(&data("brotli")).unwrap_err().to_string();
    assert_eq!(
        error,
        "tests/data/brotli.parquet: t_s: is packed with BROTLI, which is not read; write the file with zstd, snappy, gzip, lz4 \
         or no packing, in Python: pandas.read_parquet('log').to_parquet('log.parquet', compression='zstd')"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn a_packed_file_that_is_bent_or_cut_is_a_message(
        packing in 0..PACKED.len(), kept in 0.0..1.0_f64,
        bends in prop::collection::vec((0.0..1.0_f64, any::<u8>()), 1..6),
    ) {
        let whole = fs::read(data(PACKED[packing])).unwrap();
        let mut bent = whole.clone();
        for (place, value) in bends {
            bent[(place * whole.len() as f64) as usize] = value;
        }
        // Any answer is right, but a panic.
        let _ = Table::from_bytes(Path::new("a.parquet"), &bent);
        let cut = &whole[..(kept * whole.len() as f64) as usize];
        prop_assert!(Table::from_bytes(Path::new("a.parquet"), cut).is_err());
    }
}
