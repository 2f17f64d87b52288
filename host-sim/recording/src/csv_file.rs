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
/// A line that begins with this is a comment.
const COMMENT: u8 = b'#';

/// Reads the columns from any stream; `file` names it in messages. Cells are separated by tabs or `;` where the header holds
/// such, by commas otherwise; where they are not separated by commas, numbers may have a decimal comma. Lines that begin with `#`
/// are comments, of which the last before the first row names the columns where that row is of numbers; without such a one they are
/// called `[1]`, `[2]` and so on where a mapping can name them.
pub(crate) fn read(
    file: &Path,
    mut input: impl Read + Seek,
    wanted: Wanted<'_>,
) -> Result<(Header, Vec<Values>), Error> {
    let head = Head::read(&mut input).map_err(|error| Error::input(file, None, "", format!("cannot read: {error}")))?;
    let mut rows = csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(head.separator)
        .comment(Some(COMMENT))
        // Rows of another length are refused here, with a better message.
        .flexible(true)
        .buffer_capacity(BUFFER_BYTES)
        .from_reader(LastByte { inner: input, last: None });
    read_rows(&mut rows, &head, wanted).map_err(|Misread { byte, complaint }| {
        let line = byte.and_then(|byte| line_at(rows.into_inner().inner, byte).ok());
        Error::input(file, line, &complaint.column, complaint.message)
    })
}

/// What the first lines tell of the others.
struct Head {
    separator: u8,
    /// The last comment before the first row, without its sign.
    comment: Vec<u8>,
}

impl Head {
    fn read(input: &mut (impl Read + Seek)) -> io::Result<Self> {
        let mut head = Vec::new();
        input.by_ref().take(HEAD_BYTES).read_to_end(&mut head)?;
        input.seek(SeekFrom::Start(0))?;
        let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head);
        let mut comment: &[u8] = &[];
        let mut first: &[u8] = &[];
        for line in text.split(|byte| matches!(byte, b'\r' | b'\n')).filter(|line| !line.is_empty()) {
            if line[0] != COMMENT {
                first = line;
                break;
            }
            comment = line[1..].trim_ascii_start();
        }
        Ok(Self { separator: separator(first), comment: comment.to_vec() })
    }

    /// The names of the columns by the comment; none where it has not as many as the first row has cells.
    fn names(&self, cells: usize) -> Option<Vec<String>> {
        let text = std::str::from_utf8(&self.comment).ok()?;
        let names: Vec<String> =
            text.split(char::from(self.separator)).map(|name| name.trim().trim_matches('"').to_owned()).collect();
        (names.len() == cells && !names.iter().all(|name| is_number(name, self.separator))).then_some(names)
    }
}

/// What separates the cells of a line outside quotes.
fn separator(line: &[u8]) -> u8 {
    let mut quoted = false;
    let outside: Vec<u8> = line
        .iter()
        .copied()
        .filter(|byte| {
            quoted ^= *byte == b'"';
            !quoted
        })
        .collect();
    [b'\t', b';'].into_iter().find(|separator| outside.contains(separator)).unwrap_or(b',')
}

fn is_number(cell: &str, separator: u8) -> bool {
    let cell = if separator == b',' { Cow::Borrowed(cell) } else { with_decimal_point(cell) };
    cell.trim().parse::<f64>().is_ok()
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
    head: &Head,
    wanted: Wanted<'_>,
) -> Result<(Header, Vec<Values>), Misread> {
    let mut row = ByteRecord::new();
    if !next(rows, &mut row)? {
        return Err(Misread { byte: None, complaint: Complaint::new("", "the file is empty") });
    }
    let (header, is_data) = header(&row, head, wanted).map_err(|complaint| Misread::new(&row, complaint))?;
    let mut values: Vec<_> = header.columns.iter().map(|column| Values::new(column.role)).collect();
    let mut last = row.clone();
    let mut is_row = is_data || next(rows, &mut row)?;
    while is_row {
        push_row(&header, &row, head.separator, &mut values).map_err(|complaint| Misread::new(&row, complaint))?;
        std::mem::swap(&mut row, &mut last);
        is_row = next(rows, &mut row)?;
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

/// The one-based line of the row that begins at `byte`, or after the line breaks and comments there.
///
/// The line that `csv` counts lags behind by blank lines and by one where lines end as on Windows; so the lines are
/// counted afresh, once there is something to complain about.
fn line_at(mut input: impl Read + Seek, byte: u64) -> io::Result<u64> {
    input.seek(SeekFrom::Start(0))?;
    let mut bytes = BufReader::new(input);
    let mut line = 1;
    let mut left = byte;
    let mut in_comment = false;
    loop {
        let buffer = bytes.fill_buf()?;
        let Some(first) = buffer.first() else { return Ok(line) };
        if left == 0 {
            in_comment = *first == COMMENT || (in_comment && !matches!(first, b'\r' | b'\n'));
            if !in_comment && !matches!(first, b'\r' | b'\n') {
                return Ok(line);
            }
        }
        // Beyond `byte` one at a time, up to the first that is no line break.
        let count = usize::try_from(left).unwrap_or(usize::MAX).clamp(1, buffer.len());
        line += buffer[..count].iter().filter(|byte| **byte == b'\n').count() as u64;
        bytes.consume(count);
        left = left.saturating_sub(count as u64);
    }
}

/// The header, and whether the first row is one of data already.
fn header(row: &ByteRecord, head: &Head, wanted: Wanted<'_>) -> Result<(Header, bool), Complaint> {
    let cells = row.iter().enumerate().map(|(index, cell)| Ok(text(index, cell)?.trim().to_owned()));
    let cells: Vec<String> = cells.collect::<Result<_, _>>()?;
    let is_data = cells.iter().all(|cell| is_number(cell, head.separator));
    let can_be_numbered = match wanted {
        Wanted::Recording(_) => false,
        Wanted::Mapped(_, mapping) => !mapping.is_empty(),
        Wanted::Table => true,
    };
    let names = match head.names(cells.len()) {
        Some(names) if is_data => names,
        _ if is_data && can_be_numbered => (1..=cells.len()).map(|number| format!("[{number}]")).collect(),
        _ => return Ok((Header::resolve(cells, wanted)?, false)),
    };
    Ok((Header::resolve(names, wanted)?, true))
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
