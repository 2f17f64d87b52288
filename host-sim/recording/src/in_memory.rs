//! Recordings from columns that are in memory already, as data frames have them.

use std::fmt::{Debug, Formatter};
use std::path::Path;

use super::columns::{Complaint, Header, HeaderColumn, Role, Wanted};
use super::values::{Cell, Values};
use super::{AxisKind, Mapping, Recording};
use crate::Error;

/// A column of a table in memory. Cells of a column that a recording does not use are never asked for.
pub struct InMemory<'a> {
    /// Name, as a file has it in its header.
    pub name: String,
    /// One a row: none where it is null, a message where it is neither number nor text.
    pub cells: Box<dyn Iterator<Item = Result<Option<Cell>, String>> + 'a>,
}

impl Debug for InMemory<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("InMemory").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Recording {
    /// Makes a recording of columns in memory, with the checks of a file; `name` stands in answers and messages for the file.
    ///
    /// Columns that are not of the format are told by [`Recording::notes`]; their cells are not taken.
    ///
    /// # Errors
    ///
    /// As [`Recording::mapped`], with the row; columns of different lengths.
    pub fn from_columns(
        name: &str,
        columns: Vec<InMemory<'_>>,
        axis: AxisKind,
        mapping: &Mapping,
    ) -> Result<Self, Error> {
        let file = Path::new(name);
        let read = read(columns, Wanted::Mapped(axis, mapping));
        let (header, values) =
            read.map_err(|Complaint { column, message }| Error::input(file, None, &column, message))?;
        Self::assemble(file, header, values)
    }
}

fn read(columns: Vec<InMemory<'_>>, wanted: Wanted<'_>) -> Result<(Header, Vec<Values>), Complaint> {
    let names = columns.iter().map(|column| column.name.clone()).collect();
    let header = Header::resolve(names, wanted)?;
    let mut rows = None;
    let mut values = Vec::with_capacity(columns.len());
    for (column, given) in header.columns.iter().zip(columns) {
        let mut taken = Values::new(column.role);
        if matches!(column.role, Role::Known(..)) {
            let count = fill(&mut taken, column, header.mapped, given)?;
            if *rows.get_or_insert(count) != count {
                let message = format!("holds {count} rows where the columns before it hold {}", rows.unwrap_or(0));
                return Err(Complaint::new(&column.name, message));
            }
        }
        values.push(taken);
    }
    Ok((header, values))
}

/// Appends every cell, and says how many there are.
fn fill(values: &mut Values, column: &HeaderColumn, mapped: bool, given: InMemory<'_>) -> Result<usize, Complaint> {
    let mut row = 0_usize;
    for cell in given.cells {
        row += 1;
        cell.and_then(|cell| values.push_given(cell))
            .and_then(|()| values.check_last(column.role.column(), mapped))
            .map_err(|message| Complaint::new(&column.name, format!("row {row}: {message}")))?;
    }
    Ok(row)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn reals<'a>(name: &str, values: &'a [f64]) -> InMemory<'a> {
        InMemory { name: name.to_owned(), cells: Box::new(values.iter().map(|value| Ok(Some(Cell::Real(*value))))) }
    }

    fn recording(columns: Vec<InMemory<'_>>) -> Result<Recording, String> {
        Recording::from_columns("df", columns, AxisKind::Rotary, &Mapping::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn columns_in_memory_are_the_recording_that_the_same_csv_is() {
        let (t_s, position, torque) = ([0.0, 0.1, 0.2], [0.25, 0.5, 0.125], [1.0, -1.0, 0.5]);
        let modes = ["off", "damper", "brake"].map(|mode| Ok(Some(Cell::Text(mode.to_owned()))));
        let columns = vec![
            reals("t_s", &t_s),
            reals("position_rad", &position),
            reals("torque_cmd_nm", &torque),
            InMemory { name: "mode".to_owned(), cells: Box::new(modes.into_iter()) },
            InMemory { name: "seq".to_owned(), cells: Box::new((4..7).map(|seq| Ok(Some(Cell::Whole(seq))))) },
        ];
        let csv =
            "t_s,position_rad,torque_cmd_nm,mode,seq\n0,0.25,1,off,4\n0.1,0.5,-1,damper,5\n0.2,0.125,0.5,brake,6\n";
        let read = Recording::from_csv_bytes(Path::new("df"), csv.as_bytes(), None).unwrap();
        assert_eq!(recording(columns).unwrap(), read);
    }

    #[test]
    fn what_is_wrong_with_a_cell_is_told_with_its_row() {
        let (good, t_s) = ([0.0, 1.0], [0.0, 0.0]);
        let three = |t_s| vec![reals("t_s", t_s), reals("position_rad", &good), reals("torque_cmd_nm", &good)];
        assert_eq!(recording(three(&t_s)).unwrap_err(), "df: t_s: row 2: time 0 repeats; it must rise from row to row");
        assert_eq!(recording(three(&[0.0, f64::NAN])).unwrap_err(), "df: t_s: row 2: NaN is not a finite number");
        let empty = || InMemory { name: "velocity_rad_s".to_owned(), cells: Box::new(std::iter::once(Ok(None))) };
        let mut columns = three(&good);
        columns.push(empty());
        assert_eq!(recording(columns).unwrap_err(), "df: velocity_rad_s: row 1: the cell is empty");
        let mut columns = three(&good);
        columns.push(reals("temperature_c", &good[..1]));
        assert!(recording(columns).unwrap_err().ends_with("holds 1 rows where the columns before it hold 2"));
        assert!(recording(vec![reals("t_s", &good)]).unwrap_err().contains("required columns are missing"));
    }

    #[test]
    fn columns_that_are_not_of_the_format_are_told_and_not_read() {
        let good = [0.0, 1.0];
        let cells = std::iter::once_with(|| Err("nobody asks".to_owned()));
        let columns = vec![
            reals("t_s", &good),
            reals("position_rad", &good),
            InMemory { name: "humidity".to_owned(), cells: Box::new(cells) },
            reals("torque_cmd_nm", &good),
        ];
        let recording = recording(columns).unwrap();
        assert_eq!(recording.notes(), ["df: column `humidity` is not one of the format and is not used"]);
        let written: Vec<&str> = recording.columns().into_iter().map(|(name, _)| name).collect();
        assert_eq!(written, ["t_s", "position_rad", "torque_cmd_nm"]);
    }
}
