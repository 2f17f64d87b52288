//! One file for each command: its flags and what it does with them.

mod compare;
mod decode;
mod demo;
mod diagnose;
mod guide;
mod link;
mod machine;
mod paper;
mod prove;
mod record;
mod replay;
mod simulate;
mod stability;
mod tune;

use std::process::ExitCode;

use crate::Error;
use crate::output::Files;

/// What the process ends with, for `--help`.
const EXIT_CODES: &str = "\
Exit codes:
  0  done; of diagnose: whatever the verdict
  1  diagnose: the verdict is one that --fail-on lists
  2  an input that cannot be read, flags that cannot be followed, an output that cannot be written; the files
     that were there are untouched
  3  link: the drive refused
  4  link, record: no connection, or no answer";

/// Simulate, replay, compare and diagnose recordings of the servo.
#[derive(Debug, clap::Parser)]
#[command(name = "servo-lab", version, after_help = EXIT_CODES)]
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
    /// Record one run of a drive from the log it sends; the file is whole whenever the recording ends.
    Record(record::Args),
    /// Command a drive over its serial link: state, parameters, reference, experiments, recordings.
    Link(link::Args),
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
    /// Field guide: what each effect looks like, what it is confused with, what tells them apart, how small it may be.
    Guide(guide::Args),
    /// Do the main job on embedded data: loop, recording with something left out of the model, comparison.
    Demo(demo::Args),
}

/// Flag of the commands that write files.
#[derive(Debug, Clone, Copy, clap::Args)]
struct Overwrite {
    /// Replaces outputs that are there though servo-lab did not write them, and writes a model that is not believed.
    #[arg(long)]
    force: bool,
}

impl Overwrite {
    /// The files of this run, none yet.
    fn files(self) -> Files {
        Files::new(self.force)
    }
}

impl Cli {
    /// Carries the command out.
    ///
    /// # Errors
    /// Input that cannot be read, flags that cannot be followed, an output that cannot be written.
    pub fn run(&self) -> Result<ExitCode, Error> {
        match &self.command {
            Command::Diagnose(args) => return diagnose::run(args),
            Command::Simulate(args) => simulate::run(args),
            Command::Replay(args) => replay::run(args),
            Command::Compare(args) => compare::run(args),
            Command::Decode(args) => decode::run(args),
            Command::Record(args) => record::run(args),
            Command::Link(args) => link::run(args),
            Command::Prove(args) => prove::run(args),
            Command::Stability(args) => stability::run(args),
            Command::Paper(args) => paper::run(args),
            Command::Tune(args) => tune::run(args),
            Command::Guide(args) => guide::run(args),
            Command::Demo(args) => demo::run(args),
        }
        .map(|()| ExitCode::SUCCESS)
    }
}
