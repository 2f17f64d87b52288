//! One file for each command: its flags and what it does with them.

pub mod stability;

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
    /// Linear stability by four methods, margins, and what the loop tolerates
    Stability(stability::StabilityArgs),
}

impl Cli {
    /// Runs the command given.
    ///
    /// # Errors
    /// Whatever stopped the command.
    pub fn run(&self) -> Result<(), Error> {
        match &self.command {
            Command::Stability(args) => stability::run(args),
        }
    }
}
