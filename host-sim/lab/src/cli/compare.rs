//! `servo-lab compare`.

use std::path::{Path, PathBuf};

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
    /// Machine file of an improved model (`diagnose --write-model`), drawn and told beside the other.
    #[arg(long, value_name = "FILE")]
    improved: Option<PathBuf>,
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
    files.reads_all(&args.improved);
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
    // All of them before the first picture: bad input writes nothing.
    let comparisons = compared(&machine, &recordings, &names)?;
    let improved = match &args.improved {
        Some(file) => compared(&beside(file, &machine)?, &recordings, &names)?.into_iter().map(Some).collect(),
        None => vec![None; recordings.len()],
    };
    let mut text: String = warnings.iter().map(|warning| format!("warning: {warning}\n")).collect();
    for (((recording, comparison), improved), picture) in
        recordings.iter().zip(&comparisons).zip(&improved).zip(pictures)
    {
        text.extend(recording.notes().iter().map(|note| format!("note: {note}\n")));
        let title = format!("{} beside what {} makes of its commands", recording.name, machine.name);
        output::figure(&mut outputs, picture, &comparison.figure(&title, improved.as_ref()))?;
        text += &comparison.to_string();
        if let Some(improved) = improved {
            text += &format!("the improved model:\n{}", improved.beside(comparison));
        }
        text += &format!("wrote {}\n", outputs.file(picture).display());
    }
    outputs.finish()?;
    output::print(&text)
}

/// Every recording beside one machine.
fn compared<'a>(machine: &Machine, recordings: &'a [Recording], names: &[&str]) -> Result<Vec<Comparison<'a>>, Error> {
    let physics = Physics::nominal(machine, names);
    let one = |(index, recording)| Comparison::new(&physics.model_of(index), &machine.axis, recording);
    recordings.iter().enumerate().map(one).collect()
}

/// The improved machine, which must be one of the same kind.
fn beside(file: &Path, machine: &Machine) -> Result<Machine, Error> {
    let improved = Machine::read(file)?;
    if improved.axis.kind != machine.axis.kind {
        let reason = format!("{} where {} has {}", improved.axis.kind.name(), machine.name, machine.axis.kind.name());
        return Err(Error::input(file, None, "axis.kind", reason));
    }
    Ok(improved)
}
