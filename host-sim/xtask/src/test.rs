//! Everything that must hold before a change lands.

use std::process::Command;
use std::thread;
use std::time::Instant;

use crate::run::{beside, cargo, output, run};
use crate::{firmware, python, root};

/// Runs every step; one line each with its seconds, and a last line with all of them.
///
/// # Errors
///
/// The first step that fails.
pub fn all() -> Result<(), String> {
    let board = root().join("host-sim/board");
    println!("set up: {}", set_up());

    let on_board = |arguments: &[&str]| cargo(&board, arguments);
    // A workspace of its own, so it can be built beside the others: either has crates that keep one core for minutes.
    let board_build = beside(vec![
        on_board(&["clippy", "--release", "--ignore-rust-version", "--all-targets", "--", "-D", "warnings"]),
        on_board(&["test", "--release", "--ignore-rust-version", "--no-run"]),
    ]);
    let mut steps = Steps::default();
    let workspace = of_workspace(&mut steps);
    // Waited for whatever failed, so that nothing goes on when this ends.
    let built = steps.step("board clippy and build", board_build);
    workspace.and(built)?;
    steps.run("board fmt", on_board(&["fmt", "--check"]))?;
    steps.step("board tests", || board_tests(on_board))?;
    println!("xtask test: all passed: {}", steps.summary());
    Ok(())
}

/// The steps of the workspace, its image and its Python package.
fn of_workspace(steps: &mut Steps) -> Result<(), String> {
    // Its packages come over the network, and what compiles leaves that alone.
    let python = thread::spawn(python::environment);
    steps.cargo("fmt", &["fmt", "--all", "--check"])?;
    // Of the release profile, whose macros and build scripts the tests take over.
    let lint = ["clippy", "--release", "--workspace"];
    let denied = ["--", "-D", "warnings"];
    steps.cargo("clippy", &[&lint[..], &["--all-targets", "--features", "lab/probe"], &denied].concat())?;
    // Who has no probe never builds it.
    steps.cargo("clippy, no probe", &[&lint[..], &denied].concat())?;
    steps.run("doc", {
        let mut command = cargo(&root(), &["doc", "--release", "--workspace", "--no-deps", "--document-private-items"]);
        command.env("RUSTDOCFLAGS", "-D warnings");
        command
    })?;
    // Before the tests: those of the log read its strings.
    steps.step("firmware", || firmware::build().map(|image| image.print()))?;
    steps.run("tests, checked", checked())?;
    steps.cargo("tests, release", &["test", "--workspace", "--release"])?;
    // After the release build, which the wheel is made of.
    steps.step("python", || {
        python::in_all_tests(python.join().map_err(|_| "the environment was not made".to_owned())?)
    })?;
    steps.step("firmware clippy", firmware::lint)
}

/// The tests of what runs on the drive, and of its plant, with the checks of a debug build. The others are slow with them or take minutes to
/// build with all that they read files by. Of the release profile, whose libraries they share.
fn checked() -> Command {
    let mut command = cargo(&root(), &["test", "--release"]);
    for package in ["er-servo", "plant"] {
        command.args(["--package", package]);
        for check in ["overflow-checks", "debug-assertions"] {
            command.arg("--config").arg(format!("profile.release.package.{package}.{check}=true"));
        }
    }
    command
}

/// The tests of the emulated board: the commissioning, a minute of one core, beside the others.
fn board_tests(on_board: impl Fn(&[&str]) -> Command) -> Result<(), String> {
    let test = ["test", "--release", "--ignore-rust-version"];
    let commissioning = beside(vec![on_board(&[&test[..], &["--test", "commission"]].concat())]);
    let others = run(on_board(&[&test[..], &["--", "--skip", "a_drive_is_commissioned"]].concat()));
    // Both are waited for, so that nothing goes on when this ends.
    commissioning().and(others)
}

/// Runs every benchmark of the workspace.
///
/// # Errors
///
/// The benchmark that fails.
pub fn bench() -> Result<(), String> {
    run(cargo(&root(), &["bench", "--workspace"]))
}

/// Runs the tests with `UPDATE_GOLDEN=1`, which makes those with a golden file write it instead of comparing.
///
/// # Errors
///
/// A test that fails for another reason.
pub fn golden() -> Result<(), String> {
    let mut command = cargo(&root(), &["test", "--workspace"]);
    command.env("UPDATE_GOLDEN", "1");
    run(command)
}

fn set_up() -> String {
    let version =
        |program: &str| output(Command::new(program).arg("--version")).unwrap_or_else(|| format!("no {program}"));
    let cores = thread::available_parallelism().map_or(1, usize::from);
    format!("{}, {}, {cores} cores", version("rustc"), version("cargo"))
}

#[derive(Debug, Default)]
struct Steps {
    done: Vec<(String, f64)>,
}

impl Steps {
    fn cargo(&mut self, name: &str, arguments: &[&str]) -> Result<(), String> {
        self.run(name, cargo(&root(), arguments))
    }

    fn run(&mut self, name: &str, command: Command) -> Result<(), String> {
        self.step(name, || run(command))
    }

    fn step(&mut self, name: &str, act: impl FnOnce() -> Result<(), String>) -> Result<(), String> {
        println!("== {name}");
        let start = Instant::now();
        let outcome = act();
        let seconds = start.elapsed().as_secs_f64();
        let verdict = if outcome.is_ok() { "ok" } else { "FAILED" };
        println!("== {name}: {verdict}, {seconds:.1} s");
        self.done.push((name.to_owned(), seconds));
        outcome.map_err(|error| format!("step {name}: {error}"))
    }

    fn summary(&self) -> String {
        let total: f64 = self.done.iter().map(|(_, seconds)| seconds).sum();
        let each: Vec<String> = self.done.iter().map(|(name, seconds)| format!("{name} {seconds:.0} s")).collect();
        format!("{}; total {total:.0} s", each.join(", "))
    }
}
