//! `servo-lab check`: whether a machine file and recordings can be read, and what is in them.

use std::fmt::Write as _;
use std::path::PathBuf;

use crate::read::{Machine, Recording};
use crate::{Error, output};

/// Check a machine file and recordings; say what is in them
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The machine the recordings are of
    #[arg(long, value_name = "TOML")]
    machine: Option<PathBuf>,
    /// Recordings, CSV or Parquet
    #[arg(value_name = "RECORDING", required_unless_present = "machine")]
    recordings: Vec<PathBuf>,
}

pub(super) fn run(args: &Args) -> Result<(), Error> {
    let machine = args.machine.as_deref().map(Machine::read).transpose()?;
    let axis = machine.as_ref().map(|machine| machine.axis.kind);
    if let Some(Machine { name, axis, effects, .. }) = &machine {
        output::print(&format!("machine {name}: {} axis, {} effects\n", axis.kind.name(), effects.len()))?;
    }
    for file in &args.recordings {
        output::print(&summary(&Recording::read(file, axis)?))?;
    }
    Ok(())
}

fn summary(recording: &Recording) -> String {
    let (first, last) = (recording.t_s[0], recording.t_s[recording.rows() - 1]);
    let mut text = format!(
        "{}: {} axis, {} rows over {:.3} s, {} gaps\n",
        recording.name,
        recording.axis.name(),
        recording.rows(),
        last - first,
        recording.gaps.len()
    );
    for note in recording.notes() {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {note}");
    }
    text
}
