//! `servo-lab`: simulate, replay, compare and diagnose recordings of the servo.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    match lab::cli::Cli::parse().run() {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
