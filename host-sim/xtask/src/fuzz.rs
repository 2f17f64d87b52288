//! The fuzz targets, built for libFuzzer with the stable compiler: what cargo-fuzz adds is the address sanitizer, which safe
//! code has no need of.

use std::fs;
use std::process::{Command, Stdio};

use crate::root;
use crate::run::{cargo, output, run};

/// Inputs of each target in a bounded run.
const RUNS: u32 = 100_000;
/// Of the bounded run: the same inputs each time.
const SEED: u32 = 1;
/// Longest input, bytes.
const LONGEST: u32 = 2000;

/// Counters at the edges of every block, for libFuzzer to see where an input got.
const COVERAGE: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
                        -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
                        -Cllvm-args=-sanitizer-coverage-pc-table --cfg fuzzing";

/// Runs every target for a bounded number of inputs; without a C++ compiler, which libFuzzer needs, says so and runs none.
///
/// # Errors
///
/// A failed build, or a target that found an input it fails on; libFuzzer prints and keeps that input.
pub fn bounded() -> Result<(), String> {
    if output(Command::new("c++").arg("--version")).is_none() {
        println!(
            "skipped: libFuzzer needs a C++ compiler, and there is no c++; the tests' own hostile inputs have run"
        );
        return Ok(());
    }
    let host = host()?;
    build(&host, None)?;
    targets()?.iter().try_for_each(|target| {
        let mut command = fuzz(&host, target, &format!("-runs={RUNS}"), SEED);
        let outcome =
            command.output().map_err(|error| format!("fuzz target {target} could not be started: {error}"))?;
        if !outcome.status.success() {
            eprintln!("{}", String::from_utf8_lossy(&outcome.stderr));
            return Err(format!("fuzz target {target} failed ({}) on the input above", outcome.status));
        }
        println!("fuzz target {target}: {RUNS} inputs of seed {SEED}");
        Ok(())
    })
}

/// Feeds servo-lab bent recordings and machine files, each as a process that must answer within a minute: exit code 0, or 2
/// with one message. Takes hours; its faults are printed as they come.
///
/// # Errors
///
/// A failed build, or a case with a fault.
pub fn sweep() -> Result<(), String> {
    let arguments = ["test", "--release", "-p", "lab", "--test", "tool", "sweep::", "--", "--ignored", "--nocapture"];
    run(cargo(&root(), &arguments))
}

/// Runs one target for a time, with inputs that are others each time.
///
/// # Errors
///
/// As [`bounded`], and a target that is not there.
pub fn for_seconds(target: &str, seconds: u32) -> Result<(), String> {
    let targets = targets()?;
    if !targets.iter().any(|known| known == target) {
        return Err(format!("no fuzz target `{target}`; there are {}", targets.join(", ")));
    }
    let host = host()?;
    build(&host, Some(target))?;
    // 0 has libFuzzer draw the seed, which it prints.
    run(fuzz(&host, target, &format!("-max_total_time={seconds}"), 0))
}

fn targets() -> Result<Vec<String>, String> {
    let folder = root().join("host-sim/fuzz/fuzz_targets");
    let unreadable = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut names = Vec::new();
    for entry in fs::read_dir(&folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        names.extend(path.file_stem().map(|stem| stem.to_string_lossy().into_owned()));
    }
    names.sort();
    Ok(names)
}

fn host() -> Result<String, String> {
    let version = output(Command::new("rustc").arg("-vV")).ok_or("`rustc -vV` failed")?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| "`rustc -vV` names no host".to_owned())
}

/// Builds for the host as a target of its own, so that build scripts and macros go without the counters.
fn build(host: &str, target: Option<&str>) -> Result<(), String> {
    let mut command = cargo(&root().join("host-sim/fuzz"), &["build", "--release", "--target", host]);
    command.args(target.iter().flat_map(|target| ["--bin", *target])).env("RUSTFLAGS", COVERAGE);
    run(command)
}

fn fuzz(host: &str, target: &str, limit: &str, seed: u32) -> Command {
    let folder = root().join("host-sim/fuzz/target");
    let kept = folder.join(format!("{target}-"));
    let mut command = Command::new(folder.join(host).join("release").join(target));
    command.arg(limit).arg(format!("-seed={seed}")).arg(format!("-max_len={LONGEST}"));
    command.arg(format!("-artifact_prefix={}", kept.display())).stdin(Stdio::null());
    command
}
