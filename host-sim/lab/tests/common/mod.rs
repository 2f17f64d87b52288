//! What several tests share: the folder of real recordings, and servo-lab run as a user would, with limits.
#![allow(dead_code, clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::{Duration, Instant};

use assert_cmd::Command;

/// No command may take longer on one core, s.
pub const LIMIT_S: u64 = 60;
/// What it may wait beside that on a computer with other work, s.
const WAIT_S: u64 = 540;
/// No command may take more memory, kB: 4 GB of addresses, of which a process uses a part.
const MOST_KB: u64 = 4_000_000;

/// The folder of real recordings; none, with the reason printed, where it is not there. In CI it must be.
pub fn shared() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    // A worktree may lie one folder deeper than the main one.
    let found =
        ["../shared/data", "../../shared/data"].map(|folder| root.join(folder)).into_iter().find(|f| f.is_dir());
    assert!(found.is_some() || std::env::var_os("CI").is_none(), "../shared/data must be there in CI");
    if found.is_none() {
        println!("without the real recordings: ../shared/data is not there");
    }
    found
}

/// How a command ended, and what it took.
pub struct Ended {
    /// Exit code and what it printed.
    pub output: Output,
    /// From start to end, s.
    pub wall_s: f64,
    /// Of the processor, all cores; not a number where the system does not tell.
    pub cpu_s: f64,
}

/// Runs servo-lab in a folder, with the limits of a command.
pub fn run(folder: &Path, arguments: &[&str]) -> Ended {
    let times = tempfile::NamedTempFile::new().unwrap();
    let program = assert_cmd::cargo::cargo_bin("servo-lab");
    let mut command = if cfg!(unix) {
        // The shell's limit is of the processor's time, which other work does not lengthen; `times` tells it.
        let mut shell = Command::new("sh");
        let script =
            format!("ulimit -t {LIMIT_S}; ulimit -v {MOST_KB}; \"$@\"; code=$?; times > \"$TIMES\"; exit $code");
        shell.args(["-c", &script, "sh"]).arg(program).env("TIMES", times.path());
        shell
    } else {
        Command::new(program)
    };
    let limit = Duration::from_secs(LIMIT_S + WAIT_S);
    let begun = Instant::now();
    let output = command.current_dir(folder).args(arguments).timeout(limit).output().unwrap();
    let cpu_s = fs::read_to_string(times.path()).map_or(f64::NAN, |text| of_children_s(&text));
    Ended { output, wall_s: begun.elapsed().as_secs_f64(), cpu_s }
}

/// The second line of what `times` prints, user and system of the shell's children, as 1m2.03s, s.
fn of_children_s(times: &str) -> f64 {
    let seconds = |word: &str| {
        let (minutes, seconds) = word.trim_end_matches('s').split_once('m')?;
        Some(60.0 * minutes.parse::<f64>().ok()? + seconds.parse::<f64>().ok()?)
    };
    let sum = times.lines().nth(1).and_then(|line| line.split_whitespace().map(seconds).sum::<Option<f64>>());
    sum.unwrap_or(f64::NAN)
}

impl Ended {
    /// What is wrong with how it ended; none where it gave an answer, or one message and exit code 2.
    pub fn fault(&self) -> Option<String> {
        let errors = String::from_utf8_lossy(&self.output.stderr);
        match self.output.status.code() {
            Some(0) => None,
            Some(2) if errors.lines().filter(|line| !line.trim().is_empty()).count() == 1 => None,
            // Killed at the limit, as a shell tells it (128 and the signal).
            None | Some(137 | 152) => Some(format!("no answer within {LIMIT_S} s")),
            Some(code) => Some(format!("exit code {code}: {errors}")),
        }
    }
}
