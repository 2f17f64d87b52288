//! Recordings as CSV: one pass over the file, the text of one row held at a time.

use std::borrow::Cow;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use csv::ByteRecord;

use super::Column;
use super::columns::{Complaint, Header, Wanted};
use super::nearest::quoted;
use super::values::Values;
use crate::Error;

const BUFFER_BYTES: usize = 1 << 18;
/// Bytes of the header that are looked at for what separates its cells.
const HEAD_BYTES: u64 = 1 << 16;

/// Reads the columns from any stream; `file` names it in messages. Cells are separated by tabs or `;` where the header holds
/// such, by commas otherwise; where they are not separated by commas, numbers may have a decimal comma.
pub(crate) fn read(
    file: &Path,
    mut input: impl Read + Seek,
    wanted: Wanted<'_>,
) -> Result<(Header, Vec<Values>), Error> {
    let separator =
        separator(&mut input).map_err(|error| Error::input(file, None, "", format!("cannot read: {error}")))?;
    let mut rows = csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(separator)
        // Rows of another length are refused here, with a better message.
        .flexible(true)
        .buffer_capacity(BUFFER_BYTES)
        .from_reader(LastByte { inner: input, last: None });
    read_rows(&mut rows, separator, wanted).map_err(|Misread { byte, complaint }| {
        let line = byte.and_then(|byte| line_at(rows.into_inner().inner, byte).ok());
        Error::input(file, line, &complaint.column, complaint.message)
    })
}

/// What separates the cells of the first line that is not empty, outside quotes.
fn separator(input: &mut (impl Read + Seek)) -> io::Result<u8> {
    let mut head = Vec::new();
    input.by_ref().take(HEAD_BYTES).read_to_end(&mut head)?;
    input.seek(SeekFrom::Start(0))?;
    let line = head.split(|byte| matches!(byte, b'\r' | b'\n')).find(|line| !line.is_empty()).unwrap_or_default();
    let mut quoted = false;
    let outside: Vec<u8> = line
        .iter()
        .copied()
        .filter(|byte| {
            quoted ^= *byte == b'"';
            !quoted
        })
        .collect();
    Ok([b'\t', b';'].into_iter().find(|separator| outside.contains(separator)).unwrap_or(b','))
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
    separator: u8,
    wanted: Wanted<'_>,
) -> Result<(Header, Vec<Values>), Misread> {
    let mut row = ByteRecord::new();
    if !next(rows, &mut row)? {
        return Err(Misread { byte: None, complaint: Complaint::new("", "the file is empty") });
    }
    let header = header(&row, wanted).map_err(|complaint| Misread::new(&row, complaint))?;
    let mut values: Vec<_> = header.columns.iter().map(|column| Values::new(column.role)).collect();
    let mut last = row.clone();
    while next(rows, &mut row)? {
        push_row(&header, &row, separator, &mut values).map_err(|complaint| Misread::new(&row, complaint))?;
        std::mem::swap(&mut row, &mut last);
    }
    if !matches!(rows.get_ref().last, Some(b'\n' | b'\r')) {
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

fn header(row: &ByteRecord, wanted: Wanted<'_>) -> Result<Header, Complaint> {
    let names = row.iter().enumerate().map(|(index, cell)| Ok(text(index, cell)?.trim().to_owned()));
    Header::resolve(names.collect::<Result<_, _>>()?, wanted)
}

fn text(index: usize, cell: &[u8]) -> Result<&str, Complaint> {
    std::str::from_utf8(cell).map_err(|_| {
        let what = quoted(&String::from_utf8_lossy(cell));
        Complaint::new("", format!("column {}: {what} is not UTF-8 text", index + 1))
    })
}

fn push_row(header: &Header, row: &ByteRecord, separator: u8, values: &mut [Values]) -> Result<(), Complaint> {
    if row.len() != header.columns.len() {
        let message = format!(
            "the row has {} cells where the header has {}; was the file cut short, or are two runs mixed?",
            row.len(),
            header.columns.len()
        );
        return Err(Complaint::new("", message));
    }
    for (index, ((cell, column), values)) in row.iter().zip(&header.columns).zip(values).enumerate() {
        if *values == Values::Skipped {
            continue;
        }
        let cell = text(index, cell)?;
        let (name, known) = (&column.name, column.role.column());
        let cell = if separator == b',' { Cow::Borrowed(cell) } else { with_decimal_point(cell) };
        values.push(&cell).and_then(|()| values.check_last(known)).map_err(|message| {
            if cell.trim() == name && known == Some(Column::Time) {
                Complaint::new(name, "the header is repeated here: the file holds two recordings; split it")
            } else {
                Complaint::new(name, message)
            }
        })?;
    }
    Ok(())
}

/// A number with a decimal comma as one with a point; anything else as it is.
fn with_decimal_point(cell: &str) -> Cow<'_, str> {
    let Some((whole, fraction)) = cell.split_once(',') else { return Cow::Borrowed(cell) };
    let number = format!("{whole}.{fraction}");
    // A point and a comma together are a separator of thousands, of which there are two kinds.
    let is_number = !cell.contains('.') && number.trim().parse::<f64>().is_ok();
    if is_number { Cow::Owned(number) } else { Cow::Borrowed(cell) }
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
