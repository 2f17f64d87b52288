//! Any bytes as a reference: a message, or positions of one length with time that rises, which the loop can follow.
#![no_main]

use std::path::Path;

use analysis::simulate::Reference;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(reference) = Reference::from_csv_bytes(Path::new("fuzz.csv"), bytes) {
        if let Reference::Samples { t_s, reference_rad } = &reference {
            assert!(t_s.is_sorted_by(|before, after| before < after));
            assert_eq!(t_s.len(), reference_rad.len());
        }
        if let Ok(positions) = reference.positions(0.0005) {
            assert!(positions.take(10_000).count() > 0);
        }
    }
});
