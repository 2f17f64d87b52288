//! The table of a fleet: one row a diagnosis, as Parquet and back.

use std::collections::HashMap;
use std::path::Path;

use super::manifest::Task;
use crate::Error;
use crate::output::{Output, Outputs};
use crate::read::{Cells, Table};
use crate::report::Answer;

/// One diagnosis that was tried.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// As the manifest has it.
    pub task: Task,
    /// See [`Task::key`]; empty where it could not be made.
    pub key: String,
    /// The answer, or why there is none.
    pub outcome: Result<Answer, String>,
}

impl Row {
    /// The answer, if there is one.
    pub fn answer(&self) -> Option<&Answer> {
        self.outcome.as_ref().ok()
    }

    fn texts(&self) -> Result<[String; 11], serde_json::Error> {
        let Task { machine, recordings, holdout, date, .. } = &self.task;
        let [machine, recordings, holdout, date] = [machine, recordings, holdout, date].map(String::clone);
        let (error, answer) = match &self.outcome {
            Ok(answer) => (String::new(), Some(answer)),
            Err(error) => (error.clone(), None),
        };
        let of = |text: &dyn Fn(&Answer) -> String| answer.map_or_else(String::new, text);
        let ids = |answer: &Answer| answer.effects.iter().map(|one| one.id.as_str()).collect::<Vec<_>>().join(";");
        Ok([
            date,
            machine,
            recordings,
            holdout,
            error,
            of(&|answer| answer.verdict.name().to_owned()),
            of(&ids),
            of(&|answer| answer.fit.unit.clone()),
            of(&|answer| answer.warnings.join("\n")),
            answer.map(serde_json::to_string).transpose()?.unwrap_or_default(),
            self.key.clone(),
        ])
    }

    fn numbers(&self) -> [f64; 4] {
        self.answer().map_or([f64::NAN; 4], |answer| {
            let fit = &answer.fit;
            [fit.heldout_before_rms, fit.heldout_after_rms, fit.heldout_floor_rms, fit.excess_explained]
        })
    }
}

/// Columns of text, in the order of [`Row::texts`].
const TEXTS: [&str; 11] =
    ["date", "machine", "recordings", "holdout", "error", "verdict", "effects", "unit", "warnings", ANSWER, KEY];
const ANSWER: &str = "answer";
const KEY: &str = "key";
/// Columns of numbers, in the order of [`Row::numbers`].
const NUMBERS: [&str; 4] = ["heldout_before_rms", "heldout_after_rms", "heldout_floor_rms", "excess_explained"];

/// The cells of the table, column by column.
#[derive(Debug, Default)]
pub struct Columns {
    lines: Vec<u64>,
    texts: [Vec<String>; TEXTS.len()],
    numbers: [Vec<f64>; NUMBERS.len()],
}

impl Columns {
    /// Of the rows.
    ///
    /// # Errors
    /// An answer that is no JSON, which answers always are.
    pub fn of(rows: &[&Row]) -> Result<Self, serde_json::Error> {
        let mut columns = Self { lines: rows.iter().map(|row| row.task.line).collect(), ..Self::default() };
        for row in rows {
            columns.texts.iter_mut().zip(row.texts()?).for_each(|(column, cell)| column.push(cell));
            columns.numbers.iter_mut().zip(row.numbers()).for_each(|(column, cell)| column.push(cell));
        }
        Ok(columns)
    }

    /// With their names, in the order of the table.
    pub fn named(&self) -> Vec<(&'static str, Cells<'_>)> {
        let texts = TEXTS.into_iter().zip(&self.texts).map(|(name, cells)| (name, Cells::Text(cells)));
        let numbers = NUMBERS.into_iter().zip(&self.numbers).map(|(name, cells)| (name, Cells::Real(cells)));
        std::iter::once(("line", Cells::Seq(&self.lines))).chain(texts).chain(numbers).collect()
    }
}

/// Writes the table, which appears at once in the place of the one before.
///
/// # Errors
/// [`Error::Output`].
pub fn write(outputs: &mut Outputs, table: Output, rows: &[&Row]) -> Result<(), Error> {
    let failed =
        |error: serde_json::Error| Error::Output { file: outputs.file(table).to_path_buf(), reason: error.to_string() };
    let columns = Columns::of(rows).map_err(failed)?;
    outputs.table(table, "fleet", &columns.named())?;
    outputs.finish()
}

/// Answers of an earlier run by their keys; none where there is no file.
///
/// # Errors
/// A file that is no table of a fleet.
pub fn earlier(file: &Path) -> Result<HashMap<String, Answer>, Error> {
    // An empty file is one that has not been written yet.
    if std::fs::metadata(file).map_or(true, |there| there.len() == 0) {
        return Ok(HashMap::new());
    }
    let other = || Error::input(file, None, "", "is no table of a fleet; choose another name for the output");
    let columns = Table::words(file).map_err(|_| other())?;
    let column = |name: &str| columns.iter().find(|(found, _)| found == name).map(|(_, cells)| cells).ok_or_else(other);
    let pairs = column(KEY)?.iter().zip(column(ANSWER)?).filter(|(_, answer)| !answer.is_empty());
    // Of another version, whose key fits no row either.
    Ok(pairs.filter_map(|(key, answer)| Some((key.clone(), serde_json::from_str(answer).ok()?))).collect())
}
