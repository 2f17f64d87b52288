//! Any bytes as a Parquet recording: a message, or columns of one length with time that rises.
#![no_main]

use std::path::Path;

use recording::Recording;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(recording) = Recording::from_parquet_bytes(Path::new("fuzz.parquet"), bytes, None) {
        assert!(recording.t_s.is_sorted_by(|before, after| before < after));
        assert_eq!(recording.t_s.len(), recording.position.len());
        assert_eq!(recording.t_s.len(), recording.effort_cmd.len());
    }
});
