//! `servo-lab delays`.

use std::path::PathBuf;

use super::Overwrite;
use crate::Error;
use crate::delays::{Request, answer_on, figure};
use crate::output::{self, Provenance, formats};
use crate::precheck::{self, Purpose};
use crate::progress::Course;
use crate::read::{Machine, Recording};

/// Flags of `delays`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Machine file with [plant.er]; its own dead time and lag of the field are set aside.
    #[arg(long, value_name = "FILE")]
    machine: PathBuf,
    /// Recordings that only judge; without one, blocks of the others do.
    #[arg(long, value_name = "RECORDING")]
    holdout: Vec<PathBuf>,
    /// Writes the ranking as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draws where the models part, in the recordings and in the best experiment.
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    /// Recordings, of any format that is read (`help formats`).
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
}

/// Ranks the delay models of the fluid, prints the ranking, writes what was asked for.
///
/// # Errors
/// Files that cannot be read, a machine without a damper, recordings without a field, outputs that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    let mut files = args.overwrite.files();
    files.reads(&args.machine);
    files.reads_all(args.recordings.iter().chain(&args.holdout));
    let json = args.json.as_ref().map(|file| files.writes(file));
    let plot = args.plot.as_ref().map(|file| files.writes(file));
    let mut outputs = files.check()?;
    let course = Course::begin("delays");
    course.enter("reading");
    let machine = Machine::read(&args.machine)?;
    let read = |files: &[PathBuf]| -> Result<Vec<Recording>, Error> {
        files.iter().map(|file| Recording::of(file, &machine)).collect()
    };
    let (recordings, holdout) = (read(&args.recordings)?, read(&args.holdout)?);
    let warnings = precheck::warnings(&machine, &recordings, &holdout, Purpose::Diagnose)?;
    let answer = answer_on(&Request { machine: &machine, recordings: &recordings, holdout: &holdout }, &course)?;
    drop(course);
    if let Some(json) = json {
        let text = formats::json(&answer, &Provenance::of(&outputs, None)?)?;
        output::text(&mut outputs, json, &text)?;
    }
    if let Some(plot) = plot {
        output::figure(&mut outputs, plot, &figure(&answer))?;
    }
    outputs.finish()?;
    let warnings: String = warnings.iter().map(|warning| format!("warning: {warning}\n")).collect();
    output::print(&format!("{warnings}{answer}"))
}
