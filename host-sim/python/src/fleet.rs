//! Rows of a manifest, as `servo-lab fleet` diagnoses them.

use std::collections::HashMap;
use std::path::PathBuf;

use lab::Error;
use lab::fleet::table::Columns;
use lab::fleet::{Task, manifest as read_manifest, run};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::arrow::Table;
use crate::work::{done, raised};

/// Line, machine, recordings, holdout and date of a row, and the folder its files are relative to.
type Row = (u64, String, String, String, String, PathBuf);

/// The rows of a manifest.
#[pyfunction]
pub fn manifest(py: Python<'_>, file: PathBuf) -> PyResult<Vec<Row>> {
    let tasks = py.detach(|| read_manifest::read(&file)).map_err(raised)?;
    let row = |task: Task| (task.line, task.machine, task.recordings, task.holdout, task.date, task.folder);
    Ok(tasks.into_iter().map(row).collect())
}

/// Diagnoses rows of a manifest with so many threads; what is wrong with a row is in the table.
#[pyfunction]
pub fn fleet(py: Python<'_>, rows: Vec<Row>, jobs: Option<usize>) -> PyResult<Table> {
    let task =
        |(line, machine, recordings, holdout, date, folder)| Task { line, machine, recordings, holdout, date, folder };
    let tasks: Vec<Task> = rows.into_iter().map(task).collect();
    let columns = done(py, jobs, move || {
        let rows = run(&tasks, &HashMap::new(), |_| Ok(()))?;
        let columns = Columns::of(&rows.iter().collect::<Vec<_>>());
        columns.map_err(|error| Error::Usage(format!("the answer is no JSON: {error}")))
    })?;
    Table::new(&columns.named()).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}
