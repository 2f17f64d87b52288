//! Recordings as Parquet, with the columns and checks of CSV; messages carry the row in place of the line.

mod decode;
mod quiet;

use std::fs::File;
use std::path::Path;

use parquet::file::reader::{ChunkReader, FileReader};
use parquet::file::serialized_reader::SerializedFileReader;

use super::columns::{Complaint, Header};
use super::values::Values;
use super::{AxisKind, Recording};
use crate::Error;

/// More rows than this are taken for a corrupt file: 13 hours at 2 kHz.
const MOST_ROWS: usize = 100_000_000;

/// Reads the recording in `file`; the axis is `expected`, where a machine tells, and follows the units otherwise.
pub(crate) fn read(file: &Path, expected: Option<AxisKind>) -> Result<Recording, Error> {
    let input = File::open(file).map_err(|error| Error::input(file, None, "", format!("cannot open: {error}")))?;
    read_from(file, input, expected)
}

/// Reads a recording from anything that holds a Parquet file; `file` names it in messages.
pub(crate) fn read_from(
    file: &Path,
    input: impl ChunkReader + 'static,
    expected: Option<AxisKind>,
) -> Result<Recording, Error> {
    let read = quiet::caught(|| read_columns(input, expected)).unwrap_or_else(|| Err(corrupt("damaged pages")));
    let (header, values) = read.map_err(|Complaint { column, message }| Error::input(file, None, &column, message))?;
    Recording::assemble(file, header, values)
}

/// A complaint about the file, not about what is recorded in it.
fn corrupt(reason: impl std::fmt::Display) -> Complaint {
    let reason = reason.to_string().replace('\n', " ");
    Complaint::new("", format!("is not a Parquet file that can be read, or was cut short: {reason}"))
}

fn read_columns(
    input: impl ChunkReader + 'static,
    expected: Option<AxisKind>,
) -> Result<(Header, Vec<Values>), Complaint> {
    let reader = SerializedFileReader::new(input).map_err(corrupt)?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let mut names = Vec::with_capacity(schema.num_columns());
    for column in schema.columns() {
        if column.max_rep_level() > 0 || column.path().parts().len() > 1 {
            return Err(Complaint::new(&column.path().string(), "is nested; a recording has plain columns only"));
        }
        names.push(column.name().to_owned());
    }
    let header = Header::resolve(names, expected)?;
    let mut values: Vec<_> = header.columns.iter().map(|(_, column)| Values::new(*column)).collect();
    let mut rows_before = 0_usize;
    for index in 0..reader.num_row_groups() {
        let group = reader.get_row_group(index).map_err(corrupt)?;
        let rows = usize::try_from(group.metadata().num_rows()).map_err(corrupt)?;
        if rows_before.saturating_add(rows) > MOST_ROWS {
            return Err(corrupt(format!("it claims more than {MOST_ROWS} rows")));
        }
        for (index, ((name, column), values)) in header.columns.iter().zip(&mut values).enumerate() {
            let mut row = rows_before;
            decode::each_cell(group.as_ref(), index, rows, |cell| {
                row += 1;
                let cell = cell.ok_or_else(|| "the cell is empty".to_owned());
                let pushed = cell.and_then(|cell| values.push_cell(cell)).and_then(|()| values.check_last(*column));
                pushed.map_err(|message| Complaint::new(name, format!("row {row}: {message}")))
            })?;
        }
        rows_before += rows;
    }
    Ok((header, values))
}
