//! Any bytes as a log of the image, and any messages in its encoding: a refusal, or recordings whose time rises and whose
//! ticks are all there or counted as lost. `cargo xtask firmware` builds the image.
#![no_main]

#[path = "../../lab/tests/device/log.rs"]
// The tests of `lab` use the rest of it.
#[allow(dead_code)]
mod log;

use std::sync::LazyLock;

use recording::decode::recording;
use libfuzzer_sys::fuzz_target;
use wire::log::{Image, recordings};

static IMAGE: LazyLock<Image> = LazyLock::new(|| {
    let elf = log::elf().expect("the image is built");
    Image::parse(&std::fs::read(elf).expect("it can be read")).expect("it is an image")
});

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, rest)) = bytes.split_first() else { return };
    let bytes = match kind % 2 {
        0 => rest.to_vec(),
        // Messages between bars, so that the strings behind the encoding are reached.
        _ => rest
            .chunk_by(|_, next| *next != b'|')
            .flat_map(|plain| log::message(plain.get(1..).unwrap_or(&[])))
            .collect(),
    };
    let Ok(entries) = IMAGE.decode(&bytes) else { return };
    // As a whole and byte by byte, the same.
    let mut stream = IMAGE.stream();
    let pieces: Vec<_> = bytes.iter().flat_map(|byte| stream.push(&[*byte]).expect("as before")).collect();
    assert_eq!(pieces.len(), entries.len());
    for run in recordings(&entries) {
        let rows = recording("log", &run.begin, &run.frames);
        assert!(rows.t_s.is_sorted_by(|before, after| before < after));
        if let (Some(first), Some(last)) = (run.frames.first(), run.frames.last()) {
            let span = u64::from(last.seq.wrapping_sub(first.seq)) + 1;
            let before = u64::from(first.seq.wrapping_sub(run.begin.tick));
            assert_eq!(span + before, run.frames.len() as u64 + run.lost());
        }
    }
});
