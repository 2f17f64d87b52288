//! Recordings as CSV.

use std::io::{self, Write};

use super::mark;
use crate::{Cells, Recording};

/// Writes the header, with the mark of this tool, and rows; each real number in the fewest digits that read back to the same bits.
pub(super) fn write(recording: &Recording, to: impl Write) -> io::Result<()> {
    write_rows(recording, true, to)
}

/// Writes the rows alone, behind those of an earlier part with the same columns.
pub(super) fn append(recording: &Recording, to: impl Write) -> io::Result<()> {
    write_rows(recording, false, to)
}

fn write_rows(recording: &Recording, with_header: bool, mut to: impl Write) -> io::Result<()> {
    let columns = recording.columns();
    if with_header {
        let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
        to.write_all(mark::csv_header(&names).as_bytes())?;
    }
    let mut writer = csv::Writer::from_writer(to);
    let mut cell = Vec::new();
    for row in 0..recording.rows() {
        for (_, cells) in &columns {
            cell.clear();
            write_cell(&mut cell, cells, row)?;
            writer.write_field(&cell)?;
        }
        writer.write_record(None::<&[u8]>)?;
    }
    writer.flush()
}

fn write_cell(cell: &mut Vec<u8>, cells: &Cells<'_>, row: usize) -> io::Result<()> {
    match cells {
        // `{:?}` gives the shortest digits as `{}` does, with an exponent where that would be a row of zeros.
        Cells::Real(values) => write!(cell, "{:?}", values[row]),
        Cells::Mode(values) => cell.write_all(values[row].name().as_bytes()),
        Cells::Seq(values) => write!(cell, "{}", values[row]),
        Cells::Fault(values) => write!(cell, "{}", values[row]),
        Cells::Counts(values) => write!(cell, "{}", values[row]),
        Cells::Text(values) => cell.write_all(values[row].as_bytes()),
    }
}
