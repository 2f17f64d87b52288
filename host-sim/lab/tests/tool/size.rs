//! The program stays small enough to be copied to a machine.

use std::fs;

use assert_cmd::cargo::cargo_bin;

/// 17.9 MB on 64-bit Linux when this was written, its symbols among it (14.5 MB without), and a tenth to grow; it was 67 MB with
/// line tables. What goes beyond it is a library to look at, or a profile that has been changed. Kinds of the proof add to it: 38 of them came
/// with 0.1 MB, 25 more with 0.07 MB and 30 more with 0.06 MB, which are allowed for since; so are 0.05 MB for the judge's own code, which came without a
/// library, and 1.03 MB for logs of other programs: zstd in C, by which Parquet is unpacked, is 0.63 of them, the encodings of text 0.16; and
/// 0.09 MB for help, examples and looks at a log, 0.05 MB for passes of their own for machines without a state beside the rotor's, and
/// 0.12 MB for logs with rounded times, of slower buses, of numbered or named joints, of arrays and in JSON; and 0.03 MB for logs without a
/// time, with a name twice, with wrong samples or units that are not known, and what is said of them. 3.11 MB, 1.24 of them code, came with crates
/// that are no longer optimised across their units, which the profile `dist` does still.
const LARGEST_BYTES: u64 = 24_420_000;

#[test]
#[cfg_attr(debug_assertions, ignore = "of a release build")]
fn the_program_is_no_larger_than_it_was() {
    let bytes = fs::metadata(cargo_bin("servo-lab")).unwrap().len();
    println!("servo-lab: {bytes} bytes");
    assert!(bytes <= LARGEST_BYTES, "{bytes} bytes, {LARGEST_BYTES} are allowed");
}
