//! A log as it stands: names and cells, before anybody says what they are.

use std::path::Path;

use super::columns::{Header, Wanted, place};
use super::log_file::{self, Log};
use super::topics::{Series, Topic};
use super::values::Values;
use crate::Error;

/// The columns of a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Names and numbers of the columns that hold nothing but finite numbers; in the order of the file. Of one length within
    /// a topic.
    pub numbers: Vec<(String, Vec<f64>)>,
    /// Of each column of [`Table::numbers`], which topic it is of; 0 throughout where the log is one table.
    pub topics: Vec<usize>,
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
        Self::of(file, log_file::read(file, Wanted::Table)?)
    }

    /// Reads the bytes of a log of any format, which its first bytes tell; `file` names it in messages.
    ///
    /// # Errors
    ///
    /// As [`Table::read`].
    pub fn from_bytes(file: &Path, bytes: &[u8]) -> Result<Self, Error> {
        Self::of(file, log_file::read_bytes(file, bytes, Wanted::Table)?)
    }

    /// The names of all columns of a CSV or Parquet file with their cells as they are written.
    ///
    /// # Errors
    ///
    /// As [`Table::read`]; a log of several topics.
    pub fn words(file: &Path) -> Result<Vec<(String, Vec<String>)>, Error> {
        let Log::Columns(header, values) = log_file::read(file, Wanted::Table)? else {
            return Err(Error::input(file, None, "", "is no table; save it as CSV or Parquet"));
        };
        let words = |values| if let Values::Text(cells) = values { cells } else { Vec::new() };
        Ok(header.columns.into_iter().zip(values).map(|(column, values)| (column.name, words(values))).collect())
    }

    fn of(file: &Path, log: Log) -> Result<Self, Error> {
        let table = match log {
            Log::Columns(header, values) => Self::from_columns(header, values),
            Log::Topics(topics) => Self::from_topics(topics),
        };
        if table.numbers.iter().all(|(_, values)| values.is_empty()) {
            return Err(Error::input(file, None, "", "the file holds no rows of numbers"));
        }
        Ok(table)
    }

    fn from_columns(header: Header, values: Vec<Values>) -> Self {
        let mut table = Self::default();
        for (column, values) in header.columns.into_iter().zip(values) {
            table.push(0, column.name, numbers(values));
        }
        table
    }

    fn from_topics(topics: Vec<Topic>) -> Self {
        let mut table = Self::default();
        for (topic, columns) in topics.into_iter().map(|topic| topic.columns).enumerate() {
            for (name, series) in columns {
                let numbers = match series {
                    Series::Numbers(values) => {
                        Some(values).filter(|values| values.iter().all(|value| value.is_finite()))
                    }
                    Series::Texts(_) => None,
                };
                table.push(topic, name, numbers);
            }
        }
        table
    }

    fn push(&mut self, topic: usize, name: String, numbers: Option<Vec<f64>>) {
        match numbers {
            Some(numbers) => {
                self.numbers.push((name, numbers));
                self.topics.push(topic);
            }
            None => self.others.push(name),
        }
    }

    /// The whole name and the numbers of the column `name`, which may leave out the topic it is of.
    pub fn column(&self, name: &str) -> Option<(&str, &[f64])> {
        let names: Vec<String> = self.numbers.iter().map(|(name, _)| name.clone()).collect();
        let (name, values) = &self.numbers[place(&names, name)?];
        Some((name, values))
    }

    /// Which topic the column is of.
    pub(crate) fn topic(&self, name: &str) -> Option<usize> {
        self.numbers.iter().position(|(other, _)| other == name).map(|place| self.topics[place])
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
