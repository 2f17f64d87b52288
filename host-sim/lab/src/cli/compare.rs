//! `servo-lab compare`.

use std::path::PathBuf;

use diagnosis::physics::Physics;

use super::Overwrite;
use crate::output::Output;
use crate::precheck::{self, Purpose};
use crate::read::{Machine, Recording};
use crate::report::compare::Comparison;
use crate::{Error, output};

/// Flags of `compare`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Machine file: the model that is compared.
    #[arg(long, value_name = "FILE")]
    machine: PathBuf,
    /// Recordings, of any format that is read (`help formats`).
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// Folder for the pictures, one SVG a recording.
    #[arg(long, value_name = "DIR", default_value = ".")]
    plots: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Compares every recording with the model, prints the figures, writes the pictures.
///
/// # Errors
/// Files that cannot be read, recordings too short for a window, pictures that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    let mut files = args.overwrite.files();
    files.reads(&args.machine);
    files.reads_all(&args.recordings);
    let picture = |recording: &PathBuf| {
        args.plots.join(format!("compare-{}.svg", recording.file_stem().unwrap_or_default().to_string_lossy()))
    };
    let pictures: Vec<Output> = args.recordings.iter().map(|recording| files.writes(&picture(recording))).collect();
    let mut outputs = files.check()?;
    let machine = Machine::read(&args.machine)?;
    let recordings: Vec<Recording> =
        args.recordings.iter().map(|file| Recording::of(file, &machine)).collect::<Result<_, _>>()?;
    let warnings = precheck::warnings(&machine, &recordings, &[], Purpose::Compare)?;
    let names: Vec<&str> = recordings.iter().map(|recording| recording.name.as_str()).collect();
    let physics = Physics::nominal(&machine, &names);
    // All of them before the first picture: bad input writes nothing.
    let comparisons: Vec<Comparison> = recordings
        .iter()
        .enumerate()
        .map(|(index, recording)| Comparison::new(&physics.model_of(index), &machine.axis, recording))
        .collect::<Result<_, _>>()?;
    let mut text: String = warnings.iter().map(|warning| format!("warning: {warning}\n")).collect();
    for ((recording, comparison), picture) in recordings.iter().zip(&comparisons).zip(pictures) {
        text.extend(recording.notes().iter().map(|note| format!("note: {note}\n")));
        let figure = comparison.figure(&format!("{} without what {} left out", recording.name, machine.name));
        output::figure(&mut outputs, picture, &figure)?;
        text += &format!("{comparison}wrote {}\n", outputs.file(picture).display());
    }
    outputs.finish()?;
    output::print(&text)
}
