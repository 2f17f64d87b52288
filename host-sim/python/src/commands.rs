//! `servo_lab.simulate`, `compare` and `tune`.

use std::path::{Path, PathBuf};

use analysis::plot::Figure;
use analysis::simulate::{Summary, figure};
use lab::Error;
use lab::cli::{compare as compare_command, simulate as simulate_command, tune as tune_command};
use lab::output::formats;
use pyo3::prelude::*;
use recording::Machine;

use crate::arrow::Table;
use crate::diagnose::Given;
use crate::flags::parsed;
use crate::work::done;

fn svg(figure: &Figure) -> Result<String, Error> {
    let svg = figure.to_svg().map_err(|reason| Error::Output { file: PathBuf::from("SVG"), reason })?;
    Ok(formats::markup(&svg))
}

/// Runs the closed loop with the flags of the command; gives the recording, the summary and the picture.
#[pyfunction]
pub fn simulate(py: Python<'_>, words: Vec<String>) -> PyResult<(Table, String, String)> {
    let (recording, summary, picture) = done(py, None, move || {
        let run = parsed::<simulate_command::Args>(&words)?.simulate()?;
        let picture = svg(&figure(&run.rows, run.damper))?;
        Ok((run.recording("simulated"), Summary::of(&run.rows, run.period_s).to_string(), picture))
    })?;
    Ok((Table::new(&recording.columns())?, summary, picture))
}

/// One recording beside a model.
#[derive(Debug)]
#[pyclass(frozen, get_all, module = "servo_lab._servo_lab")]
pub struct Beside {
    /// Of the recording.
    name: String,
    /// What the command line prints.
    summary: String,
    /// The picture.
    svg: String,
    /// Of the sensor, rad (m).
    noise: f64,
    /// Length of each kind of window, s, and root mean square of what the model leaves, rad (m).
    nominal: Vec<(f64, f64)>,
    /// The same of the improved model.
    improved: Option<Vec<(f64, f64)>>,
}

/// Compares recordings with a model; gives the warnings, and one a recording.
#[pyfunction]
pub fn compare(
    py: Python<'_>,
    machine: PathBuf,
    recordings: Vec<(String, Bound<'_, PyAny>)>,
    improved: Option<PathBuf>,
) -> PyResult<(Vec<String>, Vec<Beside>)> {
    let recordings = Given::all(&recordings)?;
    done(py, None, move || compared(&machine, &recordings, improved.as_deref()))
}

fn compared(
    machine: &Path,
    recordings: &[Given],
    improved: Option<&Path>,
) -> Result<(Vec<String>, Vec<Beside>), Error> {
    let machine = Machine::read(machine)?;
    let recordings = recordings.iter().map(|given| given.read(&machine)).collect::<Result<Vec<_>, _>>()?;
    let compared = compare_command::compare(&machine, improved, &recordings)?;
    let one = |beside: &compare_command::Beside<'_>| {
        Ok(Beside {
            name: beside.recording.name.clone(),
            summary: beside.to_string(),
            svg: svg(&beside.figure())?,
            noise: beside.nominal.noise(),
            nominal: beside.nominal.windows().collect(),
            improved: beside.improved.as_ref().map(|improved| improved.windows().collect()),
        })
    };
    let all = compared.beside.iter().map(one).collect::<Result<_, Error>>()?;
    Ok((compared.warnings, all))
}

/// Tunes with the flags of the command; gives both gains (N m/rad, N m s/rad), summary, machine file and picture.
#[pyfunction]
pub fn tune(py: Python<'_>, words: Vec<String>) -> PyResult<(f64, f64, String, String, String)> {
    done(py, None, move || {
        let tuned = parsed::<tune_command::Args>(&words)?.tune()?;
        let machine = tuned.machine.to_toml();
        let machine =
            machine.map_err(|error| Error::Output { file: PathBuf::from("TOML"), reason: error.to_string() })?;
        let gains = tuned.tuning.best.gains;
        let picture = svg(&analysis::tune::figure(&tuned.tuning))?;
        Ok((gains.k_p_nm_rad, gains.k_d_nm_s_rad, tuned.summary, formats::toml(&machine), picture))
    })
}
