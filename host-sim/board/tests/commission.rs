//! The whole of a commissioning against the image itself: `servo-lab commission` on one end of the link, the emulated board on the
//! other.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use board::tcp::{Pace, Port};
use common::{firmware, ms, world};

/// The board's rotor (`Rotor::paper`): the paper's machine, its field late by 2 ms and 3 ms.
const TRUTH: [(&str, f64, f64); 6] = [
    ("inertia", 0.075, 0.001),
    ("torque_delay_s", 0.005, 1e-5),
    ("a", 0.0704, 0.001),
    ("b", 0.470, 0.005),
    ("dead_time_s", 0.002, 2e-5),
    ("lag_s", 0.003, 2e-5),
];
/// Longer than everything takes, ms.
const END_MS: f64 = 1_200_000.0;
/// The chips are up and the drive is ready after this, ms.
const READY_MS: f64 = 100.0;
/// The emulator answers when the machine lets it run, not within the drive's millisecond.
const PATIENCE: &str = "--patience-s 20";

fn servo_lab() -> PathBuf {
    let built = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/release/servo-lab");
    let path = std::env::var_os("SERVO_LAB").map_or(built, PathBuf::from);
    assert!(path.exists(), "{} is missing: `cargo build --release -p lab`, or name one with SERVO_LAB", path.display());
    path
}

fn run(arguments: &str, folder: &Path) -> Output {
    Command::new(servo_lab()).args(arguments.split_whitespace()).current_dir(folder).output().unwrap()
}

/// The number behind `key = ` in a machine file.
fn value(file: &str, key: &str) -> f64 {
    let line =
        file.lines().find(|line| line.split(" = ").next() == Some(key)).unwrap_or_else(|| panic!("no {key}: {file}"));
    line.split(" = ").nth(1).unwrap().parse().unwrap()
}

#[test]
fn a_drive_is_commissioned_over_the_link_of_the_image() {
    let firmware = firmware();
    let port = Port::open(0, Pace::Client).unwrap();
    let address = port.address().unwrap();
    let mut world = world(&firmware, END_MS);
    let (ended, ready) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
    (world.port, world.ended) = (Some(port), ended.clone());
    let is_ready = ready.clone();
    world.at(ms(READY_MS), move |_, _, _, _| is_ready.store(true, Ordering::Relaxed));
    let drive = std::thread::spawn(move || firmware.run(world).unwrap());

    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("commission");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    while !ready.load(Ordering::Relaxed) {
        assert!(!drive.is_finished(), "the board ended");
        std::thread::sleep(Duration::from_millis(10));
    }
    let said = run(&format!("commission --tcp {address} {PATIENCE} --out done --save"), &folder);
    let status = run(&format!("link --tcp {address} {PATIENCE} status"), &folder);
    ended.store(true, Ordering::Relaxed);
    let board = drive.join().unwrap();

    let text = String::from_utf8_lossy(&said.stdout);
    println!("{text}{}", String::from_utf8_lossy(&said.stderr));
    assert!(said.status.success() && text.contains("The drive has the tuned parameters, in flash too."), "{text}");
    assert!(board.session.resets().is_empty());
    let status = String::from_utf8_lossy(&status.stdout);
    assert!(status.contains("ready") && status.contains("30.00 us after the sample"), "{status}");
    // The delays of the file count from the outputs, which are those of the board's own motor and fluid.
    let file = std::fs::read_to_string(folder.join("done/machine.toml")).unwrap();
    assert_eq!(value(&file, "sample_to_output_s"), f64::from(er_servo::SAMPLE_TO_OUTPUT_NS) / 1e9);
    for (key, truth, off) in TRUTH {
        let found = value(&file, key);
        println!("{key}: {found}, truth {truth}");
        assert!((found - truth).abs() < off, "{key}: {found}, not {truth}");
    }
    assert!(folder.join("done/report.md").exists() && folder.join("done/step-after.csv").exists());
}
