//! `servo-lab compare`.

use std::path::{Path, PathBuf};

use crate::effects::Physics;
use crate::read::{Machine, Recording};
use crate::refit::model;
use crate::report::compare::Comparison;
use crate::{Error, output};

/// Flags of `compare`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Machine file: the model that is compared.
    #[arg(long, value_name = "FILE")]
    machine: PathBuf,
    /// Recordings, CSV or Parquet.
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// Folder for the pictures, one SVG a recording.
    #[arg(long, value_name = "DIR", default_value = ".")]
    plots: PathBuf,
}

/// Compares every recording with the model, prints the figures, writes the pictures.
///
/// # Errors
/// Files that cannot be read, recordings too short for a window, pictures that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    let machine = Machine::read(&args.machine)?;
    let recordings: Vec<Recording> =
        args.recordings.iter().map(|file| Recording::read(file, Some(machine.axis.kind))).collect::<Result<_, _>>()?;
    let names: Vec<&str> = recordings.iter().map(|recording| recording.name.as_str()).collect();
    let physics = Physics::of(&machine, &names)?;
    // All of them before the first picture: bad input writes nothing.
    let comparisons: Vec<Comparison> = recordings
        .iter()
        .enumerate()
        .map(|(index, recording)| Comparison::new(&model(&physics, index), &machine.axis, recording))
        .collect::<Result<_, _>>()?;
    for (recording, comparison) in recordings.iter().zip(&comparisons) {
        let notes: String = recording.notes().iter().map(|note| format!("note: {note}\n")).collect();
        output::print(&format!("{notes}{comparison}"))?;
        let stem = Path::new(&recording.name).file_stem().unwrap_or_default().to_string_lossy();
        let file = args.plots.join(format!("compare-{stem}.svg"));
        comparison.figure(&format!("{} without what {} left out", recording.name, machine.name)).write(&file)?;
        output::print(&format!("wrote {}\n", file.display()))?;
    }
    Ok(())
}
