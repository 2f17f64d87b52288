//! One file for each command: its flags and what it does with them.

mod compare;
mod decode;
mod demo;
mod diagnose;
mod machine;
mod paper;
mod prove;
mod replay;
mod simulate;
mod stability;
mod tune;

use crate::Error;

/// Simulate, replay, compare and diagnose recordings of the servo.
#[derive(Debug, clap::Parser)]
#[command(name = "servo-lab", version)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Run the closed loop of the flashed control law and the simulated plant; write a recording.
    Simulate(simulate::Args),
    /// Run the recorded inputs through the control law; name the first command that differs, to the bit.
    Replay(replay::Args),
    /// Drive the nominal model with the recorded commands; show where the position disagrees.
    Compare(compare::Args),
    /// Turn the log of the image (RTT bytes) into a recording.
    Decode(decode::Args),
    /// Find what the model leaves out of the recordings, with its parameters, or say that they cannot tell.
    Diagnose(diagnose::Args),
    /// Diagnose machines with concealed effects, blind, and count what was found.
    Prove(prove::Args),
    /// Stability of the linear loop by four methods: margins, limits, area, picture.
    Stability(stability::StabilityArgs),
    /// Reproduce the paper: its figures, and a table of what became of each claim.
    Paper(paper::Args),
    /// Find gains that keep margins over the uncertainty of every delay, and settle fast; write the parameter file.
    Tune(tune::Args),
    /// Do the main job on embedded data: loop, recording with something left out of the model, comparison.
    Demo(demo::Args),
}

impl Cli {
    /// Carries the command out.
    ///
    /// # Errors
    /// Input that cannot be read, flags that cannot be followed, an output that cannot be written.
    pub fn run(&self) -> Result<(), Error> {
        match &self.command {
            Command::Simulate(args) => simulate::run(args),
            Command::Replay(args) => replay::run(args),
            Command::Compare(args) => compare::run(args),
            Command::Decode(args) => decode::run(args),
            Command::Diagnose(args) => diagnose::run(args),
            Command::Prove(args) => prove::run(args),
            Command::Stability(args) => stability::run(args),
            Command::Paper(args) => paper::run(args),
            Command::Tune(args) => tune::run(args),
            Command::Demo(args) => demo::run(args),
        }
    }
}
