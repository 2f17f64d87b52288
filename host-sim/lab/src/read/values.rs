//! Cells of one column, parsed and checked.

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
}

impl Values {
    pub(crate) fn new(column: Option<Column>) -> Self {
        match column {
            None => Self::Text(Vec::new()),
            Some(Column::Mode) => Self::Mode(Vec::new()),
            Some(Column::Seq) => Self::Seq(Vec::new()),
            Some(Column::Fault) => Self::Fault(Vec::new()),
            Some(Column::Counts) => Self::Counts(Vec::new()),
            Some(_) => Self::Real(Vec::new()),
        }
    }

    /// Parses one cell and appends it; the message says what is wrong and what is allowed.
    pub(crate) fn push(&mut self, cell: &str) -> Result<(), String> {
        let cell = cell.trim();
        match self {
            Self::Text(values) => values.push(cell.to_owned()),
            _ if cell.is_empty() => return Err("the cell is empty".to_owned()),
            Self::Real(values) => values.push(real(cell)?),
            Self::Mode(values) => values.push(mode(cell)?),
            Self::Seq(values) => values.push(whole(cell)?),
            Self::Fault(values) => values.push(whole(cell)?),
            Self::Counts(values) => values.push(whole(cell)?),
        }
        Ok(())
    }

    /// Whether the last cell may follow the one before it: time and sequence numbers rise.
    pub(crate) fn check_last(&self, column: Option<Column>) -> Result<(), String> {
        match (column, self) {
            (Some(Column::Time), Self::Real(values)) => {
                values.last_chunk().map_or(Ok(()), |[before, last]| rises("time", *before, *last))
            }
            (Some(Column::Seq), Self::Seq(values)) => {
                values.last_chunk().map_or(Ok(()), |[before, last]| rises("the sequence number", *before, *last))
            }
            _ => Ok(()),
        }
    }
}

/// The number, if it is one a measurement can be.
pub(crate) fn finite(value: f64) -> Result<f64, String> {
    if value.is_finite() { Ok(value) } else { Err(format!("{value} is not a finite number")) }
}

pub(crate) fn rises<T: PartialOrd + std::fmt::Display>(what: &str, before: T, last: T) -> Result<(), String> {
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
    let bits = 8 * size_of::<T>();
    cell.parse().map_err(|_| format!("{} is not a whole number of this column's {bits} bits", quoted(cell)))
}

pub(crate) fn mode(cell: &str) -> Result<Mode, String> {
    Mode::ALL.into_iter().find(|mode| mode.name() == cell).ok_or_else(|| {
        let near = misspelt(cell, Mode::ALL.map(Mode::name));
        let hint = near.map_or_else(String::new, |word| format!("; is `{word}` meant?"));
        format!("{} is not a mode; allowed are off, damper, brake{hint}", quoted(cell))
    })
}
