//! One file for each command: its flags and what it does with them.

mod check;

use clap::{Parser, Subcommand};

use crate::Error;

/// Simulate, replay, compare and diagnose recordings of the servo.
#[derive(Debug, Parser)]
#[command(name = "servo-lab", version)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Check(check::Args),
}

/// Carries out the command.
///
/// # Errors
///
/// What the user must know, with the exit code [`Error::exit_code`].
pub fn run(cli: &Cli) -> Result<(), Error> {
    match &cli.command {
        Command::Check(args) => check::run(args),
    }
}
