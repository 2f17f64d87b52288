//! `servo-lab`: simulate, replay, compare and diagnose recordings of the servo.

use std::process::ExitCode;

use clap::Parser;
use lab::cli::{Cli, run};

fn main() -> ExitCode {
    // Flags clap cannot follow end the process here, with code 2.
    match run(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
