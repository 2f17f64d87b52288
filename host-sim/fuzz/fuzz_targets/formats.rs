//! Any bytes as a log of another program, behind the first bytes of its format: a message, or columns of one length with time
//! that rises.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use recording::{Given, Mapping, Recording, Table, guess};

/// A whole file of HDF5, for what random bytes never are.
const HDF5: &[u8] = include_bytes!("../../recording/tests/data/classic.h5");

/// The file with bytes bent: of each three the first two are a place, the third what stands there.
fn bent(file: &[u8], bends: &[u8]) -> Vec<u8> {
    let mut file = file.to_vec();
    for bend in bends.chunks_exact(3) {
        let place = usize::from(u16::from_le_bytes([bend[0], bend[1]])) % file.len();
        file[place] = bend[2];
    }
    file
}

/// What a file of each format begins and ends with: MCAP, MATLAB, ULog with its flags, JSON of SysId, a list in
/// JSON; of HDF5 a bent one.
fn dressed(kind: u8, bytes: &[u8]) -> Vec<u8> {
    const MCAP: &[u8] = b"\x89MCAP0\r\n";
    match kind % 7 {
        0 => [MCAP, bytes, MCAP].concat(),
        1 => {
            let mut header = b"MATLAB 5.0 MAT-file".to_vec();
            header.resize(124, b' ');
            [&header, &b"\0\x01IM"[..], bytes].concat()
        }
        2 => [b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0\x28\0B", &[0; 40][..], bytes].concat(),
        3 => [b"{\"sysid\":true,", bytes, b"}"].concat(),
        4 => bent(HDF5, bytes),
        5 => [b"[{", bytes, b"}]"].concat(),
        _ => bytes.to_vec(),
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, rest)) = bytes.split_first() else { return };
    let (file, log) = (Path::new("fuzz"), dressed(*kind, rest));
    // Parquet has a target of its own.
    if log.starts_with(b"PAR1") {
        return;
    }
    let Ok(table) = Table::from_bytes(file, &log) else { return };
    let Ok((axis, guesses)) = guess(&table, Given::default()) else { return };
    let columns = guesses.into_iter().map(|guess| guess.mapped).collect();
    let mapping = Mapping::new(columns, axis).expect("each column is guessed once");
    if let Ok(recording) = Recording::from_bytes(file, &log, axis, &mapping) {
        assert!(recording.t_s.is_sorted_by(|before, after| before < after));
        assert_eq!(recording.t_s.len(), recording.position.len());
        assert_eq!(recording.t_s.len(), recording.effort_cmd.len());
    }
});
