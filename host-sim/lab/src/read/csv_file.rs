//! Recordings as CSV: one pass over the file, the text of one row held at a time.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use csv::ByteRecord;

use super::columns::Header;
use super::nearest::quoted;
use super::values::Values;
use super::{AxisKind, Column, Recording};
use crate::Error;

const BUFFER_BYTES: usize = 1 << 18;

/// Reads the recording in `file`; the axis is `expected`, where a machine tells, and follows the units otherwise.
pub(crate) fn read(file: &Path, expected: Option<AxisKind>) -> Result<Recording, Error> {
    let input = File::open(file).map_err(|error| Error::input(file, None, "", format!("cannot open: {error}")))?;
    read_from(file, input, expected)
}

/// Reads a recording from any stream; `file` names it in messages.
pub(crate) fn read_from(file: &Path, input: impl Read, expected: Option<AxisKind>) -> Result<Recording, Error> {
    let mut rows = csv::ReaderBuilder::new()
        .has_headers(false)
        // Rows of another length are refused here, with a better message.
        .flexible(true)
        .buffer_capacity(BUFFER_BYTES)
        .from_reader(LastByte { inner: input, last: None });
    let mut row = ByteRecord::new();
    if !next(file, &mut rows, &mut row)? {
        return Err(Error::input(file, None, "", "the file is empty"));
    }
    let header = header(file, &row, expected)?;
    let mut values: Vec<_> = header.columns.iter().map(|(_, column)| Values::new(*column)).collect();
    let mut line = line_of(&row);
    while next(file, &mut rows, &mut row)? {
        line = line_of(&row);
        push_row(file, line, &header, &row, &mut values)?;
    }
    if rows.get_ref().last != Some(b'\n') {
        let message = "the file ends within this line: it was cut short, and its last number may be too; \
                       if it is complete, end it with a line break";
        return Err(Error::input(file, Some(line), "", message));
    }
    Recording::assemble(file, header, values)
}

/// Reads the next row; false at the end of the file.
fn next<R: Read>(file: &Path, rows: &mut csv::Reader<R>, row: &mut ByteRecord) -> Result<bool, Error> {
    rows.read_byte_record(row).map_err(|error| {
        let line = error.position().map(csv::Position::line);
        Error::input(file, line, "", format!("cannot read: {error}"))
    })
}

/// The one-based line a row begins at.
fn line_of(row: &ByteRecord) -> u64 {
    row.position().map_or(1, csv::Position::line)
}

fn header(file: &Path, row: &ByteRecord, expected: Option<AxisKind>) -> Result<Header, Error> {
    let line = line_of(row);
    let names = row.iter().enumerate().map(|(index, cell)| Ok(text(file, line, index, cell)?.trim().to_owned()));
    Header::resolve(file, Some(line), names.collect::<Result<_, Error>>()?, expected)
}

fn text<'a>(file: &Path, line: u64, index: usize, cell: &'a [u8]) -> Result<&'a str, Error> {
    std::str::from_utf8(cell).map_err(|_| {
        let what = quoted(&String::from_utf8_lossy(cell));
        Error::input(file, Some(line), "", format!("column {}: {what} is not UTF-8 text", index + 1))
    })
}

fn push_row(file: &Path, line: u64, header: &Header, row: &ByteRecord, values: &mut [Values]) -> Result<(), Error> {
    if row.len() != header.columns.len() {
        let message = format!(
            "the row has {} cells where the header has {}; was the file cut short, or are two runs mixed?",
            row.len(),
            header.columns.len()
        );
        return Err(Error::input(file, Some(line), "", message));
    }
    for (index, ((cell, (name, column)), values)) in row.iter().zip(&header.columns).zip(values).enumerate() {
        let cell = text(file, line, index, cell)?;
        let pushed = values.push(cell).and_then(|()| values.check_last(*column));
        pushed.map_err(|message| {
            let message = if cell.trim() == name && *column == Some(Column::Time) {
                "the header is repeated here: the file holds two recordings; split it".to_owned()
            } else {
                message
            };
            Error::input(file, Some(line), name, message)
        })?;
    }
    Ok(())
}

/// A stream that remembers its last byte: a file that does not end with a line break may end within a number.
struct LastByte<R> {
    inner: R,
    last: Option<u8>,
}

impl<R: Read> Read for LastByte<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        if let Some(last) = buffer[..count].last() {
            self.last = Some(*last);
        }
        Ok(count)
    }
}
