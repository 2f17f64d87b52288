//! Cells of one column, parsed and checked.

use super::columns::Role;
use super::nearest::{misspelt, quoted};
use super::{Column, Mode};

/// The cells of one column of a recording, of the type the column has.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Values {
    Real(Vec<f64>),
    Mode(Vec<Mode>),
    Seq(Vec<u64>),
    Fault(Vec<u32>),
    Counts(Vec<i64>),
    /// A column the format does not know.
    Text(Vec<String>),
    /// A column that is not read.
    Skipped,
}

impl Values {
    pub(crate) fn new(role: Role) -> Self {
        match role {
            Role::Other => Self::Text(Vec::new()),
            Role::Skipped => Self::Skipped,
            Role::Known(Column::Mode, _) => Self::Mode(Vec::new()),
            Role::Known(Column::Seq, _) => Self::Seq(Vec::new()),
            Role::Known(Column::Fault, _) => Self::Fault(Vec::new()),
            Role::Known(Column::Counts, _) => Self::Counts(Vec::new()),
            Role::Known(..) => Self::Real(Vec::new()),
        }
    }

    /// Parses one cell and appends it; the message says what is wrong and what is allowed.
    pub(crate) fn push(&mut self, cell: &str) -> Result<(), String> {
        let text = cell;
        let cell = text.trim();
        match self {
            Self::Text(values) => values.push(text.to_owned()),
            Self::Skipped => {}
            _ if cell.is_empty() => return Err("the cell is empty".to_owned()),
            Self::Real(values) => values.push(real(cell)?),
            Self::Mode(values) => values.push(mode(cell)?),
            Self::Seq(values) => values.push(whole(cell)?),
            Self::Fault(values) => values.push(whole(cell)?),
            Self::Counts(values) => values.push(whole(cell)?),
        }
        Ok(())
    }

    /// Appends one cell that has a type already.
    pub(crate) fn push_cell(&mut self, cell: Cell) -> Result<(), String> {
        match (self, cell) {
            (Self::Skipped, _) => {}
            (Self::Text(values), cell) => values.push(cell.into_text()),
            (Self::Real(values), Cell::Real(value)) => values.push(finite(value)?),
            // Counts beyond 2^53 lose their last bits, as they do where a CSV writes them as a real number.
            (Self::Real(values), Cell::Whole(value)) => values.push(value as f64),
            (Self::Mode(values), Cell::Text(word)) => values.push(mode(&word)?),
            (Self::Seq(values), Cell::Whole(value)) => values.push(narrow(value)?),
            (Self::Fault(values), Cell::Whole(value)) => values.push(narrow(value)?),
            (Self::Counts(values), Cell::Whole(value)) => values.push(narrow(value)?),
            (Self::Real(_), Cell::Text(text)) => return Err(format!("{} is text, not a number", quoted(&text))),
            // Formats without whole numbers have them as real ones.
            (values @ (Self::Seq(_) | Self::Fault(_) | Self::Counts(_)), Cell::Real(value)) if value.fract() == 0.0 => {
                return values.push_cell(Cell::Whole(value as i128));
            }
            (Self::Mode(_), cell) => return mode(&cell.into_text()).map(drop),
            (_, cell) => return Err(not_whole(&cell.into_text(), None)),
        }
        Ok(())
    }

    /// The same of a cell that may be null, which only a column that is not of the format can have.
    pub(crate) fn push_given(&mut self, cell: Option<Cell>) -> Result<(), String> {
        match (self, cell) {
            (values, Some(cell)) => values.push_cell(cell),
            (Self::Text(values), None) => {
                values.push(String::new());
                Ok(())
            }
            (_, None) => Err("the cell is empty".to_owned()),
        }
    }

    /// Whether the last cell may follow the one before it: time and sequence numbers rise. Times of a log that a mapping names may be
    /// rounded so that they repeat, which is looked at when all are there.
    pub(crate) fn check_last(&self, column: Option<Column>, mapped: bool) -> Result<(), String> {
        match (column, self) {
            (Some(Column::Time), Self::Real(values)) => {
                let pair = values.last_chunk().filter(|[before, last]| !(mapped && before == last));
                pair.map_or(Ok(()), |[before, last]| rises("time", *before, *last))
            }
            (Some(Column::Seq), Self::Seq(values)) => {
                values.last_chunk().map_or(Ok(()), |[before, last]| rises("the sequence number", *before, *last))
            }
            _ => Ok(()),
        }
    }
}

/// A cell of a table that has types.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A real number.
    Real(f64),
    /// Wide enough for signed and unsigned 64 bits.
    Whole(i128),
    /// Anything else.
    Text(String),
}

impl Cell {
    fn into_text(self) -> String {
        match self {
            Self::Real(value) => format!("{value:?}"),
            Self::Whole(value) => value.to_string(),
            Self::Text(text) => text,
        }
    }
}

/// The number that a cell of a text file holds; none where it holds no finite one.
pub(crate) fn finite_number(cell: &str) -> Option<f64> {
    cell.trim().parse::<f64>().ok().filter(|number| number.is_finite())
}

/// The number, if it is one a measurement can be.
fn finite(value: f64) -> Result<f64, String> {
    if value.is_finite() { Ok(value) } else { Err(format!("{value} is not a finite number")) }
}

fn rises<T: PartialOrd + std::fmt::Display>(what: &str, before: T, last: T) -> Result<(), String> {
    if last > before {
        Ok(())
    } else if last == before {
        Err(format!("{what} {last} repeats; it must rise from row to row"))
    } else {
        Err(format!("{what} runs back from {before} to {last}; a file must hold one run only"))
    }
}

fn real(cell: &str) -> Result<f64, String> {
    finite(cell.parse().map_err(|_| format!("{} is not a number", quoted(cell)))?)
}

fn whole<T: std::str::FromStr>(cell: &str) -> Result<T, String> {
    cell.parse().map_err(|_| not_whole(cell, Some(size_of::<T>())))
}

fn narrow<T: TryFrom<i128>>(value: i128) -> Result<T, String> {
    T::try_from(value).map_err(|_| not_whole(&value.to_string(), Some(size_of::<T>())))
}

fn not_whole(cell: &str, bytes: Option<usize>) -> String {
    let bits = bytes.map_or_else(String::new, |bytes| format!(" of this column's {} bits", 8 * bytes));
    format!("{} is not a whole number{bits}", quoted(cell))
}

fn mode(cell: &str) -> Result<Mode, String> {
    Mode::ALL.into_iter().find(|mode| mode.name() == cell).ok_or_else(|| {
        let near = misspelt(cell, Mode::ALL.map(Mode::name));
        let hint = near.map_or_else(String::new, |word| format!("; is `{word}` meant?"));
        format!("{} is not a mode; allowed are off, damper, brake{hint}", quoted(cell))
    })
}
