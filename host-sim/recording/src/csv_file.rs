//! Recordings as CSV: one pass over the file, the text of one row held at a time.

mod cells;
mod layout;
mod stream;

use std::borrow::Cow;
use std::io::{Read, Seek};
use std::path::Path;

use csv::ByteRecord;

use super::Column;
use super::columns::{Complaint, Header, HeaderColumn, NotNumber, Role, Wanted};
use super::nearest::quoted;
use super::units;
use super::values::{Values, finite_number};
use crate::Error;
use cells::{is_number, text, with_decimal_point};
use layout::{Layout, named, unit};
use stream::{Stream, line_at};

const BUFFER_BYTES: usize = 1 << 18;
/// A line that begins with this is a comment.
const COMMENT: u8 = b'#';

/// Reads the columns from any stream; `file` names it in messages. Cells are separated by tabs, `;`, commas or runs of blanks, whichever
/// makes a table of the first lines; where they are not separated by commas, or stand in quotes, numbers may have a decimal comma. Lines
/// above the header are left out, and a row of units below it is one. Lines that begin with `#` are comments, of which the last
/// before the first row names the columns where that row is of numbers; without such a one they are called `[1]`, `[2]` and so on
/// where a mapping can name them.
pub(crate) fn read(
    file: &Path,
    mut input: impl Read + Seek,
    wanted: Wanted<'_>,
) -> Result<(Header, Vec<Values>), Error> {
    let layout =
        Layout::read(&mut input).map_err(|error| Error::input(file, None, "", format!("cannot read: {error}")))?;
    let mut rows = reader(Stream::new(input, layout.blanks), layout.separator);
    let read = read_rows(&mut rows, &layout, wanted);
    let mut input = rows.into_inner().into_inner();
    let mut line = |byte| line_at(&mut input, layout.blanks, byte).ok();
    let columns = read.map_err(|Misread { byte, complaint }| {
        Error::input(file, byte.and_then(&mut line), &complaint.column, complaint.message)
    })?;
    let (mut header, values) = (columns.header, columns.values);
    header.rows_above = layout.above;
    for (column, bad) in header.columns.iter_mut().zip(columns.bad) {
        column.not_number =
            bad.and_then(|(byte, cell)| Some(NotNumber { place: format!("line {}", line(byte)?), cell }));
    }
    Ok((header, values))
}

fn reader<R: Read>(stream: Stream<R>, separator: u8) -> csv::Reader<Stream<R>> {
    csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(separator)
        .comment(Some(COMMENT))
        // Rows of another length are refused here, with a better message.
        .flexible(true)
        .buffer_capacity(BUFFER_BYTES)
        .from_reader(stream)
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

fn read_rows<'a, R: Read>(
    rows: &mut csv::Reader<Stream<R>>,
    layout: &'a Layout,
    wanted: Wanted<'_>,
) -> Result<Columns<'a>, Misread> {
    let mut row = ByteRecord::new();
    for _ in 0..layout.above {
        next(rows, &mut row)?;
    }
    if !next(rows, &mut row)? {
        return Err(Misread { byte: None, complaint: Complaint::new("", "the file is empty") });
    }
    let (header, is_data) = header(&row, layout, wanted).map_err(|complaint| Misread::new(&row, complaint))?;
    let mut columns = Columns::new(header, layout, wanted);
    let mut last = row.clone();
    if layout.units && next(rows, &mut row)? {
        columns.take_units(&row).map_err(|complaint| Misread::new(&row, complaint))?;
    }
    let mut is_row = is_data || next(rows, &mut row)?;
    if !is_row && !matches!(wanted, Wanted::Words) {
        return Err(Misread::new(&last, Complaint::new("", "the file holds a header but no rows")));
    }
    while is_row {
        columns.push(&row).map_err(|complaint| Misread::new(&row, complaint))?;
        std::mem::swap(&mut row, &mut last);
        is_row = next(rows, &mut row)?;
    }
    if !matches!(rows.get_ref().last, Some(b'\n' | b'\r')) {
        let message = "the file ends within this line: it was cut short, and its last number may be too; \
                       if it is complete, end it with a line break";
        return Err(Misread::new(&last, Complaint::new("", message)));
    }
    Ok(columns)
}

/// Reads the next row; false at the end of the file.
fn next<R: Read>(rows: &mut csv::Reader<Stream<R>>, row: &mut ByteRecord) -> Result<bool, Misread> {
    rows.read_byte_record(row).map_err(|error| Misread {
        byte: error.position().map(csv::Position::byte),
        complaint: Complaint::new("", format!("cannot read: {error}")),
    })
}

/// The header, and whether the first row is one of data already.
fn header(row: &ByteRecord, layout: &Layout, wanted: Wanted<'_>) -> Result<(Header, bool), Complaint> {
    let cells: Vec<String> = row.iter().map(|cell| text(cell).trim().to_owned()).collect();
    let cells = named(&cells);
    let is_data = cells.iter().all(|cell| is_number(cell));
    let can_be_numbered = match wanted {
        Wanted::Recording(_) => false,
        Wanted::Mapped(_, mapping) => !mapping.is_empty(),
        Wanted::Table | Wanted::Words => true,
    };
    let names = match layout.names(cells.len()) {
        Some(names) if is_data => names,
        _ if is_data && can_be_numbered => (1..=cells.len()).map(|number| format!("[{number}]")).collect(),
        _ => return Ok((Header::resolve(cells.to_vec(), wanted)?, false)),
    };
    Ok((Header::resolve(names, wanted)?, true))
}

/// The columns as far as they are read.
struct Columns<'a> {
    header: Header,
    values: Vec<Values>,
    layout: &'a Layout,
    /// Whether every row ends with a separator, behind which nothing stands; the first tells.
    ends_empty: Option<bool>,
    /// Whether cells that are no numbers are looked for: where nobody has said yet what a column is.
    looks: bool,
    /// The first cell of each column that is no number, and the byte at or before its row.
    bad: Vec<Option<(u64, String)>>,
}

impl<'a> Columns<'a> {
    fn new(header: Header, layout: &'a Layout, wanted: Wanted<'_>) -> Self {
        let values = header.columns.iter().map(|column| Values::new(column.role)).collect();
        let bad = vec![None; header.columns.len()];
        Self { header, values, layout, ends_empty: None, looks: matches!(wanted, Wanted::Table), bad }
    }

    /// Notes the units below the header; a column of the format by its name must have the unit of that name.
    fn take_units(&mut self, row: &ByteRecord) -> Result<(), Complaint> {
        for (cell, column) in row.iter().zip(&mut self.header.columns) {
            let told = unit(text(cell).trim()).to_owned();
            let is_other = units::measure(&told).is_some_and(|measure| measure.factor != 1.0);
            if !self.header.mapped && column.role.column().is_some() && is_other {
                let message = format!(
                    "the row of units says {}, but a column of this name is in the unit that the name ends with; \
                     give the unit as --map in servo-lab init",
                    quoted(&told)
                );
                return Err(Complaint::new(&column.name, message));
            }
            column.unit = Some(told).filter(|told| !told.is_empty());
        }
        Ok(())
    }

    fn push(&mut self, row: &ByteRecord) -> Result<(), Complaint> {
        self.check_length(row)?;
        let byte = row.position().map_or(0, csv::Position::byte);
        for (index, (cell, column)) in row.iter().zip(&self.header.columns).enumerate() {
            let values = &mut self.values[index];
            if *values == Values::Skipped {
                continue;
            }
            let cell = text(cell);
            let read = if self.layout.decimal_comma { with_decimal_point(&cell) } else { Cow::Borrowed(&*cell) };
            if self.looks && self.bad[index].is_none() && finite_number(&read).is_none() {
                self.bad[index] = Some((byte, read.trim().to_owned()));
            }
            let pushed = values.push(&read).and_then(|()| values.check_last(column.role.column(), self.header.mapped));
            pushed.map_err(|message| complaint(column, &read, message))?;
        }
        Ok(())
    }

    fn check_length(&mut self, row: &ByteRecord) -> Result<(), Complaint> {
        let (cells, names) = (row.len(), self.header.columns.len());
        let has_more = cells == names + 1;
        let is_empty = row.iter().next_back().is_some_and(<[u8]>::is_empty);
        if *self.ends_empty.get_or_insert(has_more && is_empty) {
            return match (has_more, is_empty) {
                (true, true) => Ok(()),
                (true, false) => Err(Complaint::new("", format!("column {cells} has no name, but holds a cell here"))),
                _ => Err(wrong_length(cells, names + 1)),
            };
        }
        if cells == names { Ok(()) } else { Err(wrong_length(cells, names)) }
    }
}

fn wrong_length(cells: usize, names: usize) -> Complaint {
    let above = if names < cells { "; lines above a header must begin with #, or hold no numbers" } else { "" };
    let message = format!(
        "the row has {cells} cells where the header has {names}; was the file cut short, or are two runs mixed?{above}"
    );
    Complaint::new("", message)
}

fn complaint(column: &HeaderColumn, cell: &str, message: String) -> Complaint {
    let name = &column.name;
    if cell.trim() == name && column.role.column() == Some(Column::Time) {
        return Complaint::new(name, "the header is repeated here: the file holds two recordings; split it");
    }
    let is_number = matches!(column.role, Role::Known(..)) && cell.contains(',') && is_number(cell);
    let comma = if is_number { "; its comma may be a decimal one or of thousands: write a decimal point" } else { "" };
    Complaint::new(name, message + comma)
}
