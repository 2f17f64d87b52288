//! The logs of `examples`: what the generators of `own_logs` make, and small.

use std::fs;
use std::path::Path;

use crate::{files, machine, root};

/// A log that is looked at in a minute, and not missed in a clone, bytes.
const LARGEST: u64 = 200_000;

/// What comes before the sizes in a MATLAB file is a text with the date.
const MAT_TEXT_BYTES: usize = 116;

/// The logs, without the README.
const LOGS: [&str; 3] = ["pendulum.csv", "arm.mcap", "axis.mat"];

/// Writes all logs into a folder.
fn write(folder: &Path) {
    fs::write(folder.join("pendulum.csv"), files::csv(&machine::pushed_pendulum(20.0))).unwrap();
    files::write_mcap(&folder.join("arm.mcap"), &machine::cogging_joint(0.008));
    files::write_mat(&folder.join("axis.mat"), &machine::sprung_axis(0.002));
}

/// Copies the logs of the repository into a folder.
pub fn copy(folder: &Path) {
    fs::create_dir_all(folder).unwrap();
    for log in LOGS {
        fs::copy(root().join("examples").join(log), folder.join(log)).unwrap();
    }
}

/// `cargo xtask golden` writes them.
#[test]
fn the_examples_are_what_their_generators_make() {
    let known = root().join("examples");
    if std::env::var_os("UPDATE_GOLDEN").is_some_and(|value| value == "1") {
        write(&known);
    }
    let made = tempfile::tempdir().unwrap();
    write(made.path());
    for log in LOGS {
        let [known, made] = [&known, made.path()].map(|folder| fs::read(folder.join(log)).unwrap());
        assert!(known.len() as u64 <= LARGEST, "{log}: {} bytes", known.len());
        let from = if log.ends_with(".mat") { MAT_TEXT_BYTES } else { 0 };
        assert!(known[from..] == made[from..], "{log} is another; if that is meant, `cargo xtask golden` writes it");
    }
}
