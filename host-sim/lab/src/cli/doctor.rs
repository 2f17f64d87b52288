//! `servo-lab doctor`: whether everything is there that a drive needs, and whether a log is fit to be diagnosed.

mod log;
mod machine;
mod motion;
mod shows;
mod skew;

use std::path::PathBuf;
use std::process::ExitCode;

use crate::read::{Given, Machine, MapFlag};
use crate::{Error, output};

/// Flags of `doctor`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Logs to look at: rate, jitter, gaps, delay between torque and motion, saturation, and which effects their motion shows;
    /// without one, the tools and rights of this computer.
    #[arg(value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Machine file whose section `columns` says what the columns are; without it, they are guessed as init does.
    #[arg(long, value_name = "FILE")]
    machine: Option<PathBuf>,
    /// What a column is, as init takes it.
    #[arg(long, value_name = "KEY=NAME:UNIT*SCALE", conflicts_with = "machine")]
    map: Vec<MapFlag>,
    /// The joint, where the logs hold several.
    #[arg(long, value_name = "NAME", conflicts_with = "machine")]
    joint: Option<String>,
    /// Ends with exit code 1 where a log has a line of this kind, or of a worse one.
    #[arg(long, value_enum, value_name = "KIND")]
    fail_on: Option<State>,
}

/// Whether something is as it should be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
enum State {
    #[value(skip)]
    Good,
    /// Works, or is needed for some things only.
    Note,
    /// Worth a new recording.
    Bad,
}

/// One thing that was looked at.
#[derive(Debug, Clone, PartialEq)]
struct Check {
    state: State,
    what: &'static str,
    /// What was found, and what to do where it is not good.
    found: String,
}

impl Check {
    fn new(state: State, what: &'static str, found: impl Into<String>) -> Self {
        Self { state, what, found: found.into() }
    }
}

fn text(checks: &[Check]) -> String {
    let line = |check: &Check| {
        let state = match check.state {
            State::Good => "ok  ",
            State::Note => "note",
            State::Bad => "BAD ",
        };
        format!("{state}  {:12} {}\n", check.what, check.found)
    };
    checks.iter().map(line).collect()
}

/// Looks at this computer, or at logs, and prints what was found; exit code 1 is what `--fail-on` asks for.
///
/// # Errors
/// Files that cannot be read.
pub fn run(args: &Args) -> Result<ExitCode, Error> {
    if args.logs.is_empty() {
        // What of it is needed depends on what is to be done.
        output::print(&text(&machine::checks()))?;
        return Ok(ExitCode::SUCCESS);
    }
    let machine = args.machine.as_deref().map(Machine::read).transpose()?;
    let given = Given { flags: &args.map, joint: args.joint.as_deref(), axis: None };
    let (mut all, mut worst) = (String::new(), State::Good);
    for file in &args.logs {
        let checks = log::checks(file, machine.as_ref(), given)?;
        worst = checks.iter().map(|check| check.state).fold(worst, State::max);
        all += &format!("{}\n{}", file.display(), text(&checks));
    }
    output::print(&all)?;
    Ok(if args.fail_on.is_some_and(|kind| worst >= kind) { ExitCode::from(1) } else { ExitCode::SUCCESS })
}
