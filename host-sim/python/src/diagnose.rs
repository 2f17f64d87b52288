//! `servo_lab.diagnose`, and where recordings come from.

use std::path::{Path, PathBuf};

use lab::cli::diagnose::SEED;
use lab::conclude::{self, OfFiles};
use lab::output::{Input, Provenance, formats, sha256};
use lab::progress::Course;
use lab::report::html::{PlotData, page};
use lab::report::{improved_machine, summary};
use lab::{Error, propose};
use pyo3::prelude::*;
use recording::{Machine, Recording};

use crate::arrow::Batches;
use crate::work::done;

/// A recording as Python gives it.
#[derive(Debug)]
pub enum Given {
    /// A file, of any format that is read.
    File(PathBuf),
    /// A table in memory, under the name that answers give it.
    Table(String, Batches),
}

impl Given {
    /// Of names and what is a path or a table.
    ///
    /// # Errors
    /// What is neither.
    pub fn all(recordings: &[(String, Bound<'_, PyAny>)]) -> PyResult<Vec<Self>> {
        let one = |(name, data): &(String, Bound<'_, PyAny>)| match data.extract::<PathBuf>() {
            Ok(file) => Ok(Self::File(file)),
            Err(_) => Ok(Self::Table(name.clone(), Batches::of(name, data)?)),
        };
        recordings.iter().map(one).collect()
    }

    /// Reads a recording of the machine.
    ///
    /// # Errors
    /// As [`Recording::of`].
    pub fn read(&self, machine: &Machine) -> Result<Recording, Error> {
        match self {
            Self::File(file) => Recording::of(file, machine),
            Self::Table(name, table) => {
                Recording::from_columns(name, table.columns(), machine.axis.kind, &machine.columns)
            }
        }
    }

    fn input(&self) -> Result<Input, Error> {
        match self {
            Self::File(file) => input(file),
            Self::Table(name, _) => Ok(Input { file: name.clone(), sha256: None }),
        }
    }
}

fn input(file: &Path) -> Result<Input, Error> {
    let sha256 = sha256(file).map_err(|error| Error::input(file, None, "", error.to_string()))?;
    Ok(Input { file: file.display().to_string(), sha256 })
}

/// What a diagnosis gives, each as the command line writes it.
#[derive(Debug)]
#[pyclass(frozen, get_all, module = "servo_lab._servo_lab")]
pub struct Diagnosed {
    /// `--json`.
    json: String,
    /// Standard output.
    summary: String,
    /// `--write-model`.
    improved_machine: String,
    /// `--experiment`, where the verdict is ambiguous.
    reference_csv: Option<String>,
    /// `--html`, where it was asked for.
    page: Option<String>,
}

/// What is asked, apart from the recordings.
struct Asked {
    machine: PathBuf,
    only: Vec<String>,
    without: Vec<String>,
    page: bool,
}

/// Diagnoses recordings, each a name and a path or a table.
#[pyfunction]
#[pyo3(signature = (machine, recordings, holdout, only, without, jobs, page))]
// One argument for each of the Python function's, which checks them.
#[allow(clippy::too_many_arguments)]
pub fn diagnose(
    py: Python<'_>,
    machine: PathBuf,
    recordings: Vec<(String, Bound<'_, PyAny>)>,
    holdout: Vec<(String, Bound<'_, PyAny>)>,
    only: Vec<String>,
    without: Vec<String>,
    jobs: Option<usize>,
    page: bool,
) -> PyResult<Diagnosed> {
    let (recordings, holdout) = (Given::all(&recordings)?, Given::all(&holdout)?);
    let asked = Asked { machine, only, without, page };
    done(py, jobs, move || diagnosed(&asked, &recordings, &holdout))
}

fn diagnosed(asked: &Asked, recordings: &[Given], holdout: &[Given]) -> Result<Diagnosed, Error> {
    let vocabulary = conclude::vocabulary(&asked.only, &asked.without)?;
    let machine = Machine::read(&asked.machine)?;
    let read = |given: &[Given]| given.iter().map(|one| one.read(&machine)).collect::<Result<Vec<_>, _>>();
    let (fitted, held_out) = (read(recordings)?, read(holdout)?);
    let made = Provenance {
        command: "servo_lab.diagnose".to_owned(),
        inputs: std::iter::once(input(&asked.machine))
            .chain(recordings.iter().chain(holdout).map(Given::input))
            .collect::<Result<_, _>>()?,
        ..Provenance::without_inputs(Some(SEED))
    };
    let OfFiles { machine, recordings, holdout, diagnosis } =
        conclude::of_recordings(machine, fitted, held_out, &vocabulary, &Course::unseen())?;
    let answer = &diagnosis.answer;
    let text = std::fs::read_to_string(&asked.machine)
        .map_err(|error| Error::input(&asked.machine, None, "", error.to_string()))?;
    let proposal = diagnosis.proposal.as_ref().filter(|proposal| !proposal.reference.is_empty());
    Ok(Diagnosed {
        json: formats::json(answer, &made)?,
        summary: summary(answer),
        improved_machine: formats::toml(&improved_machine(&text, answer)),
        reference_csv: proposal.map(|proposal| propose::reference_csv(machine.axis.kind, &proposal.reference)),
        page: if asked.page {
            let plot = PlotData::new(&diagnosis, &recordings, &holdout)?;
            Some(formats::markup(&page(&machine.name, answer, &plot, &made)?))
        } else {
            None
        },
    })
}
