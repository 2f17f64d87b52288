//! Recordings as CSV: one pass over the file, the text of one row held at a time.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use csv::ByteRecord;

use super::columns::{Complaint, Header};
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
pub(crate) fn read_from(file: &Path, input: impl Read + Seek, expected: Option<AxisKind>) -> Result<Recording, Error> {
    let mut rows = csv::ReaderBuilder::new()
        .has_headers(false)
        // Rows of another length are refused here, with a better message.
        .flexible(true)
        .buffer_capacity(BUFFER_BYTES)
        .from_reader(LastByte { inner: input, last: None });
    match read_rows(&mut rows, expected) {
        Ok((header, values)) => Recording::assemble(file, header, values),
        Err(Misread { byte, complaint }) => {
            let line = byte.and_then(|byte| line_at(rows.into_inner().inner, byte).ok());
            Err(Error::input(file, line, &complaint.column, complaint.message))
        }
    }
}

/// What is wrong, and the byte at or before the row it is in.
struct Misread {
    byte: Option<u64>,
    complaint: Complaint,
}

impl Misread {
    fn new(row: &ByteRecord, complaint: Complaint) -> Self {
        Self { byte: row.position().map(csv::Position::byte), complaint }
    }
}

fn read_rows<R: Read>(
    rows: &mut csv::Reader<LastByte<R>>,
    expected: Option<AxisKind>,
) -> Result<(Header, Vec<Values>), Misread> {
    let mut row = ByteRecord::new();
    if !next(rows, &mut row)? {
        return Err(Misread { byte: None, complaint: Complaint::new("", "the file is empty") });
    }
    let header = header(&row, expected).map_err(|complaint| Misread::new(&row, complaint))?;
    let mut values: Vec<_> = header.columns.iter().map(|(_, column)| Values::new(*column)).collect();
    let mut last = row.clone();
    while next(rows, &mut row)? {
        push_row(&header, &row, &mut values).map_err(|complaint| Misread::new(&row, complaint))?;
        std::mem::swap(&mut row, &mut last);
    }
    if rows.get_ref().last != Some(b'\n') {
        let message = "the file ends within this line: it was cut short, and its last number may be too; \
                       if it is complete, end it with a line break";
        return Err(Misread::new(&last, Complaint::new("", message)));
    }
    Ok((header, values))
}

/// Reads the next row; false at the end of the file.
fn next<R: Read>(rows: &mut csv::Reader<R>, row: &mut ByteRecord) -> Result<bool, Misread> {
    rows.read_byte_record(row).map_err(|error| Misread {
        byte: error.position().map(csv::Position::byte),
        complaint: Complaint::new("", format!("cannot read: {error}")),
    })
}

/// The one-based line of the row that begins at `byte`, or after the line breaks there.
///
/// The line that `csv` counts lags behind by blank lines and by one where lines end as on Windows; so the lines are
/// counted afresh, once there is something to complain about.
fn line_at(mut input: impl Read + Seek, byte: u64) -> io::Result<u64> {
    input.seek(SeekFrom::Start(0))?;
    let mut bytes = BufReader::new(input);
    let mut line = 1;
    let mut left = byte;
    loop {
        let buffer = bytes.fill_buf()?;
        let Some(first) = buffer.first() else { return Ok(line) };
        if left == 0 && !matches!(first, b'\r' | b'\n') {
            return Ok(line);
        }
        // Beyond `byte` one at a time, up to the first that is no line break.
        let count = usize::try_from(left).unwrap_or(usize::MAX).clamp(1, buffer.len());
        line += buffer[..count].iter().filter(|byte| **byte == b'\n').count() as u64;
        bytes.consume(count);
        left = left.saturating_sub(count as u64);
    }
}

fn header(row: &ByteRecord, expected: Option<AxisKind>) -> Result<Header, Complaint> {
    let names = row.iter().enumerate().map(|(index, cell)| Ok(text(index, cell)?.trim().to_owned()));
    Header::resolve(names.collect::<Result<_, _>>()?, expected)
}

fn text(index: usize, cell: &[u8]) -> Result<&str, Complaint> {
    std::str::from_utf8(cell).map_err(|_| {
        let what = quoted(&String::from_utf8_lossy(cell));
        Complaint::new("", format!("column {}: {what} is not UTF-8 text", index + 1))
    })
}

fn push_row(header: &Header, row: &ByteRecord, values: &mut [Values]) -> Result<(), Complaint> {
    if row.len() != header.columns.len() {
        let message = format!(
            "the row has {} cells where the header has {}; was the file cut short, or are two runs mixed?",
            row.len(),
            header.columns.len()
        );
        return Err(Complaint::new("", message));
    }
    for (index, ((cell, (name, column)), values)) in row.iter().zip(&header.columns).zip(values).enumerate() {
        let cell = text(index, cell)?;
        values.push(cell).and_then(|()| values.check_last(*column)).map_err(|message| {
            if cell.trim() == name && *column == Some(Column::Time) {
                Complaint::new(name, "the header is repeated here: the file holds two recordings; split it")
            } else {
                Complaint::new(name, message)
            }
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
