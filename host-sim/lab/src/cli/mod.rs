//! One file for each command: its flags and what it does with them.

mod commission;
pub mod compare;
mod convert;
mod decode;
mod delays;
mod demo;
pub mod diagnose;
mod doctor;
mod effort_units;
mod examples;
mod experiment_flags;
mod fleet;
mod guide;
mod help;
mod init;
mod link;
mod machine;
mod paper;
mod prove;
mod record;
mod replay;
pub mod simulate;
mod stability;
pub mod tune;
mod velocity_check;

use std::process::ExitCode;
use std::time::Instant;

use crate::Error;
use crate::output::Files;

/// What the process ends with, for `--help`.
const EXIT_CODES: &str = "\
Exit codes:
  0  done; of diagnose: whatever the verdict
  1  diagnose: the verdict is one that --fail-on lists
  2  an input that cannot be read, flags that cannot be followed, an output that cannot be written; the files
     that were there are untouched
  3  link, record, commission: the drive refused
  4  link, record, commission: no connection, or no answer";

/// Simulate, replay, compare and diagnose recordings of the servo.
#[derive(Debug, clap::Parser)]
#[command(name = "servo-lab", version, after_help = EXIT_CODES, disable_help_subcommand = true)]
pub struct Cli {
    /// Shows no progress.
    #[arg(long, short, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Tells on standard error which build this is, how long it took, and of a diagnosis how long each stage.
    #[arg(long, short, global = true)]
    verbose: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Guess a machine file from logs as they are: columns, units, sampling, and a first model.
    #[command(after_help = examples::INIT)]
    Init(init::Args),
    /// Write a log of any format that is read as a recording: CSV, Parquet or MCAP.
    #[command(after_help = examples::CONVERT)]
    Convert(convert::Args),
    /// Look whether everything is there that a drive needs, or whether a log is fit to be diagnosed.
    #[command(after_help = examples::DOCTOR)]
    Doctor(doctor::Args),
    /// Run the closed loop of the flashed control law and the simulated plant; write a recording.
    #[command(after_help = examples::SIMULATE)]
    Simulate(simulate::Args),
    /// Run the recorded inputs through the control law; name the first command that differs, to the bit.
    #[command(after_help = examples::REPLAY)]
    Replay(replay::Args),
    /// Drive the nominal model with the recorded commands; show where the position disagrees.
    #[command(after_help = examples::COMPARE)]
    Compare(compare::Args),
    /// Turn the log of the image (RTT bytes) into a recording.
    #[command(after_help = examples::DECODE)]
    Decode(decode::Args),
    /// Record one run of a drive from the log it sends; the file is whole whenever the recording ends.
    #[command(after_help = examples::RECORD)]
    Record(record::Args),
    /// Command a drive over its serial link: state, parameters, reference, experiments, recordings.
    #[command(after_help = format!("{}\n\n{EXIT_CODES}", examples::LINK))]
    Link(link::Args),
    /// Commission a drive: a step, the machine by experiments, what its model leaves out, gains, the step again; the axis moves.
    #[command(after_help = format!("{}\n\n{EXIT_CODES}", examples::COMMISSION))]
    Commission(commission::Args),
    /// Find what the model leaves out of the recordings, with its parameters, or say that they cannot tell.
    #[command(after_help = format!("{}\n\n{EXIT_CODES}", examples::DIAGNOSE))]
    Diagnose(diagnose::Args),
    /// Diagnose many machines: each row of a manifest over all cores, into one table that a later run goes on with.
    #[command(after_help = examples::FLEET)]
    Fleet(fleet::Args),
    /// Rank the delays a fluid can have, none to dead time and lag of its field, and say what would tell them apart.
    #[command(after_help = examples::DELAYS)]
    Delays(delays::Args),
    /// Diagnose machines with concealed effects, blind, and count what was found.
    #[command(after_help = examples::PROVE)]
    Prove(prove::Args),
    /// Stability of the linear loop by four methods: margins, limits, area, picture.
    #[command(after_help = examples::STABILITY)]
    Stability(stability::StabilityArgs),
    /// Reproduce the paper: its figures, and a table of what became of each claim.
    #[command(after_help = examples::PAPER)]
    Paper(paper::Args),
    /// Find gains that keep margins over the uncertainty of every delay, and settle fast; write the parameter file.
    #[command(after_help = examples::TUNE)]
    Tune(tune::Args),
    /// Field guide: what each effect looks like, what it is confused with, what tells them apart, how small it may be.
    #[command(after_help = examples::GUIDE)]
    Guide(guide::Args),
    /// Do the main job on embedded data: loop, recording with something left out of the model, comparison.
    #[command(after_help = examples::DEMO)]
    Demo(demo::Args),
    /// Explain a command, the vocabulary of effects, or the formats of logs.
    #[command(after_help = examples::HELP)]
    Help(help::HelpArgs),
    /// Print completions for a shell.
    #[command(after_help = examples::COMPLETIONS)]
    Completions(help::CompletionsArgs),
    /// Write a man page for every command.
    #[command(after_help = examples::MAN)]
    Man(help::ManArgs),
}

/// More threads than any machine has cores; to start a million of them takes for ever.
const MOST_THREADS: usize = 1024;

/// A number of threads, as a flag.
fn threads(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=MOST_THREADS).contains(count));
    count.ok_or_else(|| format!("must be a whole number from 1 to {MOST_THREADS}"))
}

/// Has everything that is computed use that many threads.
fn use_threads(jobs: Option<usize>) -> Result<(), Error> {
    let Some(jobs) = jobs else { return Ok(()) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build_global();
    pool.map_err(|error| Error::Usage(format!("--jobs {jobs}: {error}")))
}

/// Flag of the commands that write files.
#[derive(Debug, Clone, Copy, clap::Args)]
struct Overwrite {
    /// Replaces outputs that are there though servo-lab did not write them.
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
        if !self.quiet {
            crate::progress_bar::show();
        }
        let start = Instant::now();
        let outcome = self.carry_out();
        if self.verbose {
            let (version, commit) = (env!("CARGO_PKG_VERSION"), env!("SERVO_LAB_COMMIT"));
            eprintln!("servo-lab {version}, commit {commit}: took {:.3} s", start.elapsed().as_secs_f64());
        }
        outcome
    }

    fn carry_out(&self) -> Result<ExitCode, Error> {
        match &self.command {
            Command::Diagnose(args) => return diagnose::run(args, self.verbose),
            Command::Doctor(args) => return doctor::run(args),
            Command::Help(args) => help::help(args),
            Command::Completions(args) => help::completions(args),
            Command::Man(args) => help::man(args),
            Command::Delays(args) => delays::run(args),
            Command::Fleet(args) => fleet::run(args),
            Command::Convert(args) => convert::run(args),
            Command::Init(args) => init::run(args),
            Command::Simulate(args) => simulate::run(args),
            Command::Replay(args) => replay::run(args),
            Command::Compare(args) => compare::run(args),
            Command::Decode(args) => decode::run(args),
            Command::Record(args) => record::run(args),
            Command::Link(args) => link::run(args),
            Command::Commission(args) => commission::run(args),
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
