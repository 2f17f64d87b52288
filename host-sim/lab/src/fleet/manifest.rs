//! The manifest: which recordings of which machines are diagnosed.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::Error;
use crate::output::sha256;
use crate::read::{Table, misspelt};

/// Columns that a manifest may have; the first two it must.
const COLUMNS: [&str; 4] = ["machine", "recordings", "holdout", "date"];
/// Between the files of one cell.
const SEPARATOR: char = ';';

/// One diagnosis of the manifest, its cells as they are written.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Task {
    /// Line in the manifest, from 1 and with the header; of a Parquet file as if it were CSV. Blank lines are not counted.
    pub line: u64,
    /// Machine file.
    pub machine: String,
    /// Recordings to fit, `;` between them.
    pub recordings: String,
    /// Recordings that are only predicted; empty for none.
    pub holdout: String,
    /// When it was recorded, ISO 8601; empty where that is not told.
    pub date: String,
    /// What its files are relative to.
    pub folder: PathBuf,
}

/// The diagnoses of a manifest, CSV or Parquet; files in it are relative to its folder.
///
/// # Errors
/// [`Error::Input`] for a file that is no table, lacks a column or has one that is not known.
pub fn read(file: &Path) -> Result<Vec<Task>, Error> {
    let columns = Table::words(file)?;
    let wrong = |key: &str, message: String| Err(Error::input(file, Some(1), key, message));
    if let Some((other, _)) = columns.iter().find(|(name, _)| !COLUMNS.contains(&name.as_str())) {
        let near = misspelt(other, COLUMNS).map_or_else(String::new, |near| format!("; is `{near}` meant?"));
        return wrong(other, format!("unknown column; a manifest has {}{near}", COLUMNS.join(", ")));
    }
    let column = |name: &str| columns.iter().find(|(other, _)| other == name).map(|(_, cells)| cells);
    let (Some(machine), Some(recordings)) = (column(COLUMNS[0]), column(COLUMNS[1])) else {
        return wrong("", format!("a manifest must have the columns {} and {}", COLUMNS[0], COLUMNS[1]));
    };
    let (holdout, date) = (column(COLUMNS[2]), column(COLUMNS[3]));
    let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
    let cell = |cells: Option<&Vec<String>>, row: usize| cells.map_or("", |cells| cells[row].trim()).to_owned();
    let task = |row: usize| Task {
        line: row as u64 + 2,
        machine: cell(Some(machine), row),
        recordings: cell(Some(recordings), row),
        holdout: cell(holdout, row),
        date: cell(date, row),
        folder: folder.clone(),
    };
    let tasks: Vec<Task> = (0..machine.len()).map(task).collect();
    if tasks.is_empty() { wrong("", "there is no row to diagnose".to_owned()) } else { Ok(tasks) }
}

impl Task {
    /// Its machine file.
    pub fn machine_file(&self) -> PathBuf {
        self.folder.join(&self.machine)
    }

    /// Its recordings to fit, then those held out.
    pub fn recording_files(&self) -> [Vec<PathBuf>; 2] {
        let files = |cell: &str| {
            let names = cell.split(SEPARATOR).map(str::trim).filter(|name| !name.is_empty());
            names.map(|name| self.folder.join(name)).collect()
        };
        [files(&self.recordings), files(&self.holdout)]
    }

    /// What tells it from every other: SHA-256 of this program's version and commit and of the content of its files. Whatever
    /// changes one of them has it done again.
    ///
    /// # Errors
    /// A cell that is empty or no date, a file that cannot be read.
    pub fn key(&self) -> Result<String, Error> {
        for (name, cell) in COLUMNS.iter().zip([&self.machine, &self.recordings]) {
            if cell.is_empty() {
                return Err(Error::Usage(format!("{name}: the cell is empty")));
            }
        }
        if !self.date.is_empty() && day(&self.date).is_none() {
            return Err(Error::Usage(format!("date: `{}` is no date as 2026-03-31 is", self.date)));
        }
        let mut hasher = Sha256::new();
        hasher.update(concat!(env!("CARGO_PKG_VERSION"), " ", env!("SERVO_LAB_COMMIT")));
        let [recordings, holdout] = self.recording_files();
        for (part, files) in [("machine", vec![self.machine_file()]), ("fit", recordings), ("holdout", holdout)] {
            for file in files {
                let content = sha256(&file).map_err(|error| Error::input(&file, None, "", error.to_string()))?;
                let Some(content) = content else {
                    return Err(Error::input(&file, None, "", "is no regular file"));
                };
                // The name too: it stands in the answer.
                let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                hasher.update(format!("\n{part} {name} {content}"));
            }
        }
        Ok(hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
    }
}

/// The instant of an ISO 8601 date with or without a time; none for what is no date.
fn day(date: &str) -> Option<std::time::SystemTime> {
    humantime::parse_rfc3339_weak(date).or_else(|_| humantime::parse_rfc3339_weak(&format!("{date}T00:00:00Z"))).ok()
}
