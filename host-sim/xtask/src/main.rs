//! The one entry for developers and CI: `cargo xtask <command>`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};

mod firmware;
mod flash;
mod fuzz;
mod option_bytes;
mod python;
mod run;
mod test;
mod toolchain;

/// Builds, checks and tests everything.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Format, lints as errors, docs, the image, every test, the emulated board; stops at the
    /// first failure.
    Test,
    /// Builds the release image for the STM32F427 and prints what it takes of flash and RAM.
    Firmware {
        /// Reads the option bytes of the part on the probe, and says what of them does not fit a drive; halts the core for a
        /// moment, so with the drive disabled.
        #[arg(long)]
        check: bool,
    },
    /// Builds the image and writes it to the drive on the probe, which halts its core: with the drive disabled. Parameters and
    /// events in flash stay.
    Flash {
        /// Shows the image's events until Ctrl-C.
        #[arg(long)]
        watch: bool,
    },
    /// Runs the release image on the emulated board with the plant behind its pins.
    Board {
        /// What follows goes to the emulated board; `--help` lists it.
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Runs every fuzz target for a bounded number of inputs and then the sweep of bent recordings, or one target for a time;
    /// an input that fails is kept in `host-sim/fuzz/target`.
    Fuzz {
        /// One of `host-sim/fuzz/fuzz_targets`.
        #[arg(long)]
        target: Option<String>,
        /// For how long, s.
        #[arg(long, default_value_t = 60, requires = "target")]
        seconds: u32,
    },
    /// Builds the Python package in an environment under `target/python` and runs its tests.
    Python,
    /// Runs every benchmark.
    Bench,
    /// Rewrites the golden files from what the tests compute now; look at the diff before committing it.
    Golden,
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Test => test::all(),
        Command::Firmware { check: true } => option_bytes::check(),
        Command::Firmware { check: false } => firmware::build().map(|image| image.print()),
        Command::Flash { watch } => flash::flash(watch),
        Command::Board { arguments } => firmware::board(&arguments),
        Command::Fuzz { target: Some(target), seconds } => fuzz::for_seconds(&target, seconds),
        Command::Fuzz { target: None, .. } => fuzz::bounded().and_then(|()| fuzz::sweep()),
        Command::Python => python::test(),
        Command::Bench => test::bench(),
        Command::Golden => test::golden(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// Root of the workspace.
fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here).to_path_buf()
}
