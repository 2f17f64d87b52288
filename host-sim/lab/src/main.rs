//! servo-lab.

use std::process::ExitCode;

use clap::Parser;
use lab::cli::Cli;

fn main() -> ExitCode {
    match Cli::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("servo-lab: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
