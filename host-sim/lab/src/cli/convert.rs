//! `servo-lab convert`.

use std::path::PathBuf;

use super::Overwrite;
use crate::read::{Machine, Recording};
use crate::{Error, output};

/// Flags of `convert`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Log to convert, of any format that is read; - for standard input.
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// Machine file whose section `columns` says what the columns are; without it, the log must have those of the format.
    #[arg(long, value_name = "FILE")]
    machine: Option<PathBuf>,
    /// Where the recording goes, in the units of the format: .csv, .parquet or .mcap.
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Reads the log and writes it as a recording.
///
/// # Errors
/// A log that cannot be read as a recording, an output that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    let mut files = args.overwrite.files();
    files.reads(&args.log);
    files.reads_all(&args.machine);
    let out = files.writes(&args.out);
    let mut outputs = files.check()?;
    let recording = match &args.machine {
        Some(file) => Recording::of(&args.log, &Machine::read(file)?)?,
        None => Recording::read(&args.log, None)?,
    };
    outputs.recording(out, &recording)?;
    outputs.finish()?;
    let names: Vec<&str> = recording.columns().iter().map(|(name, _)| *name).collect();
    let mut text: String = recording.notes().iter().map(|note| format!("note: {note}\n")).collect();
    text += &format!("wrote {}: {} rows of {}\n", args.out.display(), recording.rows(), names.join(", "));
    output::print(&text)
}
