//! `servo-lab compare`.

mod page;

use std::fmt::{Display, Formatter};
use std::path::{Path, PathBuf};

use diagnosis::physics::Physics;

use super::Overwrite;
use crate::output::{Output, Provenance, formats};
use crate::plot::Figure;
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
    /// Writes figures and pictures as one page that opens in a browser.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
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
    let html = args.html.as_ref().map(|file| files.writes(file));
    let mut outputs = files.check()?;
    let machine = Machine::read(&args.machine)?;
    let recordings: Vec<Recording> =
        args.recordings.iter().map(|file| Recording::of(file, &machine)).collect::<Result<_, _>>()?;
    // All of them before the first picture: bad input writes nothing.
    let compared = compare(&machine, args.improved.as_deref(), &recordings)?;
    let mut text: String = compared.warnings.iter().map(|warning| format!("warning: {warning}\n")).collect();
    for (beside, picture) in compared.beside.iter().zip(pictures) {
        output::figure(&mut outputs, picture, &beside.figure())?;
        text += &format!("{beside}wrote {}\n", outputs.file(picture).display());
    }
    if let Some(html) = html {
        let page = page::page(&machine.name, &compared, &Provenance::of(&outputs, None)?)?;
        output::text(&mut outputs, html, &formats::markup(&page))?;
    }
    outputs.finish()?;
    output::print(&text)
}

/// Recordings beside a model.
#[derive(Debug)]
pub struct Compared<'a> {
    /// What the data themselves show.
    pub warnings: Vec<String>,
    /// One a recording.
    pub beside: Vec<Beside<'a>>,
}

/// One recording beside a model, and beside an improved one.
#[derive(Debug)]
pub struct Beside<'a> {
    machine: &'a str,
    /// The recording.
    pub recording: &'a Recording,
    /// What the model leaves of it.
    pub nominal: Comparison<'a>,
    /// What the improved model leaves of it, where there is one.
    pub improved: Option<Comparison<'a>>,
}

impl Beside<'_> {
    /// The picture.
    pub fn figure(&self) -> Figure {
        let title = format!("{} beside what {} makes of its commands", self.recording.name, self.machine);
        self.nominal.figure(&title, self.improved.as_ref())
    }
}

impl Display for Beside<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        self.recording.notes().iter().try_for_each(|note| writeln!(f, "note: {note}"))?;
        write!(f, "{}", self.nominal)?;
        match &self.improved {
            Some(improved) => write!(f, "the improved model:\n{}", improved.beside(&self.nominal)),
            None => Ok(()),
        }
    }
}

/// Compares recordings with a machine and, where its file is given, with an improved one; writes nothing.
///
/// # Errors
/// A file of another kind of machine or none, data that nothing can be computed from, recordings too short for a window.
pub fn compare<'a>(
    machine: &'a Machine,
    improved: Option<&Path>,
    recordings: &'a [Recording],
) -> Result<Compared<'a>, Error> {
    let warnings = precheck::warnings(machine, recordings, &[], Purpose::Compare)?;
    let names: Vec<&str> = recordings.iter().map(|recording| recording.name.as_str()).collect();
    let nominal = compared(machine, recordings, &names)?;
    let improved = match improved {
        Some(file) => compared(&beside(file, machine)?, recordings, &names)?.into_iter().map(Some).collect(),
        None => vec![None; recordings.len()],
    };
    let all = recordings.iter().zip(nominal).zip(improved);
    let one =
        |((recording, nominal), improved)| Beside { machine: machine.name.as_str(), recording, nominal, improved };
    Ok(Compared { warnings, beside: all.map(one).collect() })
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
