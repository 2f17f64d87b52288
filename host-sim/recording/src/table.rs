//! A log as it stands: names and cells, before anybody says what they are.

use std::path::Path;

use super::columns::{Header, NotNumber, Wanted, place};
use super::log_file::{self, Log};
use super::nearest::quoted;
use super::topics::{Series, Topic};
use super::units;
use super::values::{Values, finite_number};
use crate::Error;

/// The columns of a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Names and numbers of the columns that hold nothing but finite numbers; in the order of the file. Of one length within
    /// a topic.
    pub numbers: Vec<(String, Vec<f64>)>,
    /// Of each column of [`Table::numbers`], which topic it is of; 0 throughout where the log is one table.
    pub topics: Vec<usize>,
    /// Of each column of [`Table::numbers`], what a row of units below the header says; empty where nothing does.
    pub units: Vec<Option<String>>,
    /// Names of the other columns.
    pub others: Vec<String>,
    /// Of each of [`Table::others`], the first cell that is no finite number and where it is: `` `#N/A` in line 17 ``.
    pub not_numbers: Vec<String>,
    /// Rows above the header of a CSV file, which are left out: titles and settings.
    pub rows_above: usize,
}

impl Table {
    /// Reads the log in `file`, of any format of [`crate::FORMATS`]; `-` is standard input.
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
        let Log::Columns(header, values) = log_file::read(file, Wanted::Words)? else {
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
            let why = table.others.iter().zip(&table.not_numbers).next();
            let why = why.map_or_else(String::new, |(name, cell)| format!(": {} holds {cell}", quoted(name)));
            return Err(Error::input(file, None, "", format!("the file holds no column of numbers{why}")));
        }
        Ok(table)
    }

    fn from_columns(header: Header, values: Vec<Values>) -> Self {
        let mut table = Self { rows_above: header.rows_above, ..Self::default() };
        for (column, values) in header.columns.into_iter().zip(values) {
            let numbers = numbers(values).map_err(|bad| column.not_number.unwrap_or(bad));
            table.push(0, column.name, column.unit, numbers);
        }
        table
    }

    fn from_topics(topics: Vec<Topic>) -> Self {
        let mut table = Self::default();
        for (topic, columns) in topics.into_iter().map(|topic| topic.columns).enumerate() {
            for (name, series) in columns {
                let numbers = match series {
                    Series::Numbers(values) => finite(values),
                    Series::Texts(cells) => Err(NotNumber::at(0, cells.first().map_or("", String::as_str))),
                };
                table.push(topic, name, None, numbers);
            }
        }
        table
    }

    fn push(&mut self, topic: usize, name: String, unit: Option<String>, numbers: Result<Vec<f64>, NotNumber>) {
        match numbers {
            Ok(numbers) => {
                self.numbers.push((name, numbers));
                self.topics.push(topic);
                self.units.push(unit);
            }
            Err(NotNumber { place, cell }) => {
                self.others.push(name);
                self.not_numbers.push(format!("{} in {place}", quoted(&cell)));
            }
        }
    }

    /// The whole name and the numbers of the column `name`, which may leave out the topic it is of.
    pub fn column(&self, name: &str) -> Option<(&str, &[f64])> {
        let names: Vec<String> = self.numbers.iter().map(|(name, _)| name.clone()).collect();
        let (name, values) = &self.numbers[place(&names, name)?];
        Some((name, values))
    }

    /// The unit of the column, by its name or by a row of units, as [`units::measure`] takes it.
    pub(crate) fn unit(&self, name: &str) -> Option<String> {
        let below = || {
            let place = self.numbers.iter().position(|(other, _)| other == name)?;
            self.units.get(place)?.clone().filter(|unit| units::measure(unit).is_some())
        };
        units::told(name).or_else(below)
    }

    /// Why the column of this name is none of numbers: its first cell that is none, and where it is.
    pub(crate) fn not_number(&self, name: &str) -> Option<&str> {
        let place = self.others.iter().position(|other| other == name)?;
        self.not_numbers.get(place).map(String::as_str)
    }

    /// Which topic the column is of.
    pub(crate) fn topic(&self, name: &str) -> Option<usize> {
        self.numbers.iter().position(|(other, _)| other == name).map(|place| self.topics[place])
    }
}

/// The cells as numbers, or the first that is none.
fn numbers(values: Values) -> Result<Vec<f64>, NotNumber> {
    match values {
        Values::Real(values) => finite(values),
        Values::Text(cells) => {
            let number = |(row, cell): (usize, &String)| finite_number(cell).ok_or_else(|| NotNumber::at(row, cell));
            cells.iter().enumerate().map(number).collect()
        }
        _ => Err(NotNumber::at(0, "")),
    }
}

fn finite(values: Vec<f64>) -> Result<Vec<f64>, NotNumber> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(row) => Err(NotNumber::at(row, &values[row].to_string())),
        None => Ok(values),
    }
}
