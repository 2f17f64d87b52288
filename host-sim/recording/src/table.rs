//! A log as it stands: names and cells, before anybody says what they are.

use std::path::Path;

use super::columns::{Header, Wanted};
use super::log_file;
use super::values::Values;
use crate::Error;

/// The columns of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Names and numbers of the columns that hold nothing but finite numbers; in the order of the file, of one length.
    pub numbers: Vec<(String, Vec<f64>)>,
    /// Names of the other columns.
    pub others: Vec<String>,
}

impl Table {
    /// Reads the log in `file`, of any format of [`crate::READABLE`]; `-` is standard input.
    ///
    /// # Errors
    ///
    /// [`Error::Input`] for a file that cannot be read as a table with a header and at least one row.
    pub fn read(file: &Path) -> Result<Self, Error> {
        let (header, values) = log_file::read(file, Wanted::Table)?;
        let table = Self::from_columns(header, values);
        if table.numbers.iter().all(|(_, values)| values.is_empty()) {
            return Err(Error::input(file, None, "", "the file holds no rows of numbers"));
        }
        Ok(table)
    }

    fn from_columns(header: Header, values: Vec<Values>) -> Self {
        let mut table = Self { numbers: Vec::new(), others: Vec::new() };
        for (column, values) in header.columns.into_iter().zip(values) {
            match numbers(values) {
                Some(numbers) => table.numbers.push((column.name, numbers)),
                None => table.others.push(column.name),
            }
        }
        table
    }

    /// The numbers of the column `name`.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.numbers.iter().find(|(other, _)| other == name).map(|(_, values)| values.as_slice())
    }
}

/// The cells as numbers; none where one is none.
fn numbers(values: Values) -> Option<Vec<f64>> {
    match values {
        Values::Real(values) => Some(values),
        Values::Text(cells) => {
            let number = |cell: &String| cell.trim().parse::<f64>().ok().filter(|number| number.is_finite());
            cells.iter().map(number).collect()
        }
        _ => None,
    }
}
