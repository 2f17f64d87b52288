//! Logs as files: what is decoded replays, what is missing is counted, what is another image's is refused.

use std::fs;

use er_servo::{Config, State};
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};
use recording::decode::runs;
use wire::log::{Entry, Image};

use crate::drive::Machine;
use crate::log::{Encoder, elf, other_build};
use crate::{fails, printed};

/// The image, and the log of a run of a few hundred ticks.
fn image_and_log(run: u32, lose_at: Option<u32>) -> Option<(Vec<u8>, Vec<u8>)> {
    let elf = fs::read(elf()?).unwrap();
    Some((elf.clone(), log(&elf, run, lose_at)))
}

fn log(elf: &[u8], run: u32, lose_at: Option<u32>) -> Vec<u8> {
    let encoder = Encoder::of(elf);
    let mut machine = Machine::ready(Some(encoder.clone()));
    machine.log.extend(encoder.event("er-servo is up"));
    if let Some(at) = lose_at {
        machine.start(run, at);
        machine.lose = 7;
        machine.finish(200);
    } else {
        machine.record_step(run, 300);
    }
    machine.log
}

#[test]
fn a_decoded_log_replays_identical() {
    let Some((elf, log)) = image_and_log(3, None) else { return };
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("image"), &elf).unwrap();
    fs::write(at("rtt.bin"), &log).unwrap();
    let output = crate::lab(folder.path(), "decode --elf image rtt.bin");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "run 3: 325 ticks, 0 lost in 0 gaps, 0 damaged messages\n");
    fs::write(at("rec.csv"), &output.stdout).unwrap();
    let replayed = printed(folder.path(), "replay rec.csv");
    assert!(replayed.starts_with("rec.csv: identical, 325 rows"), "{replayed}");
    // Row by row and as a whole, the same file; and standard input as good as a file.
    for (name, from) in [("file.csv", "rtt.bin"), ("input.csv", "-")] {
        let mut command = assert_cmd::Command::cargo_bin("servo-lab").unwrap();
        command.current_dir(folder.path()).args(["record", "--elf", "image", "--out", name, from]);
        let output = command.write_stdin(log.clone()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(fs::read(at(name)).unwrap(), fs::read(at("rec.csv")).unwrap(), "{name}");
    }
}

#[test]
fn lost_frames_are_gaps_in_a_recording_that_still_replays() {
    let Some((elf, log)) = image_and_log(3, Some(40)) else { return };
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("image"), &elf).unwrap();
    fs::write(folder.path().join("rtt.bin"), &log).unwrap();
    for command in ["decode --elf image rtt.bin --out rec.csv", "record --elf image rtt.bin --out rec.csv"] {
        let output = crate::lab(folder.path(), command);
        let summary = String::from_utf8_lossy(&output.stderr);
        assert!(summary.contains("7 lost in 1 gaps, 0 damaged messages"), "{command}: {summary}");
        let replayed = printed(folder.path(), "replay rec.csv");
        assert!(replayed.contains("rows are missing in 1 place") && replayed.contains("identical"), "{replayed}");
    }
}

#[test]
fn a_wrong_elf_file_is_refused_with_the_reason_and_nothing_written() {
    let Some((elf, log)) = image_and_log(3, None) else { return };
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("rtt.bin"), &log).unwrap();
    fs::write(at("other"), other_build(&elf)).unwrap();
    fs::write(at("text"), "no ELF file").unwrap();
    fs::copy(assert_cmd::cargo::cargo_bin("servo-lab"), at("host")).unwrap();
    for (elf, reason) in [
        ("other", "the log was written by build"),
        ("text", "not the ELF file of an er-servo image"),
        ("host", "not the ELF file of an er-servo image"),
        ("missing", "missing"),
    ] {
        for command in ["decode", "record"] {
            let message = fails(folder.path(), &format!("{command} --elf {elf} rtt.bin --out rec.csv"), 2);
            assert!(message.contains(reason), "{command}: {message}");
        }
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4, "no recording, no temporary file");
}

#[test]
fn several_runs_are_told_apart() {
    let Some((elf, mut bytes)) = image_and_log(3, None) else { return };
    bytes.extend(log(&elf, 4, None));
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("image"), &elf).unwrap();
    fs::write(folder.path().join("rtt.bin"), &bytes).unwrap();
    let message = fails(folder.path(), "decode --elf image rtt.bin", 2);
    assert!(message.contains("which one?; the log holds runs 3, 4"), "{message}");
    printed(folder.path(), "decode --elf image rtt.bin --run 4 --out rec.csv");
    assert!(printed(folder.path(), "replay rec.csv").contains("identical"));
    let message = fails(folder.path(), "record --elf image rtt.bin --run 5 --out no.csv", 2);
    assert!(message.contains("no start of run 5"), "{message}");
}

#[test]
fn other_parameters_are_told_so_that_a_machine_file_can_have_them() {
    let Some((elf, _)) = image_and_log(3, None) else { return };
    let config = Config { kp_nm_rad: 300.0, hold: !Config::default().hold, ..Config::default() };
    let encoder = Encoder::of(&elf);
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("image"), &elf).unwrap();
    fs::write(folder.path().join("rtt.bin"), encoder.begin(1, 0, &State::default(), &config)).unwrap();
    for command in ["decode --elf image rtt.bin --out rec.csv", "record --elf image rtt.bin --out rec.csv"] {
        let notes = String::from_utf8(crate::lab(folder.path(), command).stderr).unwrap();
        assert!(notes.contains("\nkp_nm_rad = 300 # N m/rad, 0 to 5000\n") && notes.contains("\nhold = "), "{notes}");
        assert_eq!(notes.lines().count(), 4, "{notes}");
    }
}

#[test]
fn a_reset_ends_the_run_before_it() {
    let Some((elf, log)) = image_and_log(3, None) else { return };
    let encoder = Encoder::of(&elf);
    let half = log.iter().enumerate().filter(|(_, byte)| **byte == 0).nth(100).unwrap().0 + 1;
    let bytes = [&log[..half], &encoder.event("er-servo 0.1.0, build [..]"), &log[half..]].concat();
    let [run] = &runs(&elf, &bytes).unwrap()[..] else { panic!("not one run") };
    assert_eq!((run.frames.len(), run.lost(), run.damaged), (99, 0, 0));
}

#[test]
fn damage_costs_the_messages_it_hits_and_is_counted() {
    let Some((elf, log)) = image_and_log(3, None) else { return };
    let ends: Vec<usize> = log.iter().enumerate().filter(|(_, byte)| **byte == 0).map(|(at, _)| at).collect();
    // Behind the event and the begin, a byte in the middle of the 40th frame; and the zero between two others.
    let mut damaged = log.clone();
    damaged[ends[41] - 20] ^= 0x55;
    damaged[ends[60]] = 1;
    let run = &runs(&elf, &damaged).unwrap()[0];
    assert_eq!(run.frames.len() as u64 + run.lost(), 325);
    assert!((2..=3).contains(&run.lost()), "{} lost", run.lost());
    assert_eq!(run.damaged, 2);
}

#[test]
fn a_log_cut_short_anywhere_gives_what_came() {
    let Some((elf, log)) = image_and_log(3, None) else { return };
    let image = Image::parse(&elf).unwrap();
    for end in (0..log.len()).step_by(23) {
        let entries = image.decode(&log[..end]).unwrap();
        let zeros = log[..end].iter().filter(|byte| **byte == 0).count();
        assert_eq!(entries.len(), zeros, "cut at {end}");
        assert!(!entries.contains(&Entry::Damaged), "cut at {end}");
    }
}

/// Seed of the hostile logs.
const SEED: u64 = 4;

#[test]
fn hostile_logs_never_panic() {
    let Some((elf, log)) = image_and_log(3, None) else { return };
    let image = Image::parse(&elf).unwrap();
    let endless = image.decode(&vec![0x55; 1 << 20]).unwrap_err().to_string();
    assert!(endless.contains("messages are none of this image"), "{endless}");
    let mut random = StdRng::seed_from_u64(SEED);
    let (mut refused, mut decoded) = (0, 0);
    for case in 0..600 {
        let mut bytes = if case % 6 == 0 {
            (0..random.random_range(0..5000)).map(|_| random.random()).collect()
        } else {
            log[..log.len().min(4000)].to_vec()
        };
        for _ in 0..random.random_range(1..40) {
            let at = random.random_range(0..=bytes.len());
            match random.random_range(0..4) {
                0 if at < bytes.len() => bytes[at] ^= 1 << random.random_range(0..8),
                1 => bytes.insert(at, random.random_range(0..3)),
                2 if at < bytes.len() => drop(bytes.drain(at..(at + random.random_range(1..60)).min(bytes.len()))),
                _ => bytes.insert(at, random.random()),
            }
        }
        match image.decode(&bytes) {
            Ok(entries) => decoded += entries.iter().filter(|entry| matches!(entry, Entry::Frame(_))).count(),
            Err(error) => {
                assert_eq!(error.to_string().lines().count(), 1);
                refused += 1;
            }
        }
    }
    println!("seed {SEED}: {refused} of 600 logs refused, {decoded} frames decoded of the others");
    assert!(refused > 0 && decoded > 10_000);
}
