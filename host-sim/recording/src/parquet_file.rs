//! Recordings as Parquet, with the columns and checks of CSV; messages carry the row in place of the line.

mod decode;

use std::path::Path;

use parquet::basic::Compression;
use parquet::file::metadata::RowGroupMetaData;
use parquet::file::reader::{ChunkReader, FileReader};
use parquet::file::serialized_reader::SerializedFileReader;

use super::columns::{Complaint, Header, Wanted};
use super::quiet;
use super::values::Values;
use crate::Error;

/// More rows than this are taken for a corrupt file: 13 hours at 2 kHz.
const MOST_ROWS: usize = 100_000_000;

/// Reads the columns of anything that holds a Parquet file; `file` names it in messages.
pub(crate) fn read(
    file: &Path,
    input: impl ChunkReader + 'static,
    wanted: Wanted<'_>,
) -> Result<(Header, Vec<Values>), Error> {
    let read = quiet::caught(|| read_columns(input, wanted)).unwrap_or_else(|| Err(corrupt("damaged pages")));
    read.map_err(|Complaint { column, message }| Error::input(file, None, &column, message))
}

/// A complaint about the file, not about what is recorded in it.
fn corrupt(reason: impl std::fmt::Display) -> Complaint {
    let reason = reason.to_string().replace('\n', " ");
    Complaint::new("", format!("is not a Parquet file that can be read, or was cut short: {reason}"))
}

fn read_columns(input: impl ChunkReader + 'static, wanted: Wanted<'_>) -> Result<(Header, Vec<Values>), Complaint> {
    let reader = SerializedFileReader::new(input).map_err(corrupt)?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let mut names = Vec::with_capacity(schema.num_columns());
    for column in schema.columns() {
        if column.max_rep_level() > 0 || column.path().parts().len() > 1 {
            return Err(Complaint::new(&column.path().string(), "is nested; a recording has plain columns only"));
        }
        names.push(column.name().to_owned());
    }
    let header = Header::resolve(names, wanted)?;
    let mut values: Vec<_> = header.columns.iter().map(|column| Values::new(column.role)).collect();
    let mut rows_before = 0_usize;
    for index in 0..reader.num_row_groups() {
        let group = reader.get_row_group(index).map_err(corrupt)?;
        let rows = usize::try_from(group.metadata().num_rows()).map_err(corrupt)?;
        if rows_before.saturating_add(rows) > MOST_ROWS {
            return Err(corrupt(format!("it claims more than {MOST_ROWS} rows")));
        }
        for (index, (column, values)) in header.columns.iter().zip(&mut values).enumerate() {
            if *values == Values::Skipped {
                continue;
            }
            refuse_packing(group.metadata(), index, &column.name)?;
            let mut row = rows_before;
            decode::each_cell(group.as_ref(), index, rows, |cell| {
                row += 1;
                let pushed =
                    values.push_given(cell).and_then(|()| values.check_last(column.role.column(), header.mapped));
                pushed.map_err(|message| Complaint::new(&column.name, format!("row {row}: {message}")))
            })?;
        }
        rows_before += rows;
    }
    Ok((header, values))
}

/// Refuses what is packed in a way that is not read, before it looks damaged.
fn refuse_packing(group: &RowGroupMetaData, index: usize, name: &str) -> Result<(), Complaint> {
    let packing = match group.column(index).compression() {
        Compression::BROTLI(_) => "BROTLI",
        Compression::LZO => "LZO",
        _ => return Ok(()),
    };
    let message = format!(
        "is packed with {packing}, which is not read; write the file with zstd, snappy, gzip, lz4 or no packing, in Python: \
         pandas.read_parquet('log').to_parquet('log.parquet', compression='zstd')"
    );
    Err(Complaint::new(name, message))
}
