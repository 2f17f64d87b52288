//! Recordings read from files and bytes of any format.

use std::io::Cursor;
use std::path::Path;

use bytes::Bytes;

use super::columns::Wanted;
use super::{AxisKind, Machine, Mapping, Recording, csv_file, log_file, parquet_file};
use crate::Error;

impl Recording {
    /// Reads the recording in `file`, of any format of [`crate::FORMATS`], with the columns of the format; `-` is standard
    /// input.
    ///
    /// `expected` is the axis of the machine the recording is of; without one the axis follows the units of the columns.
    ///
    /// # Errors
    ///
    /// [`Error::Input`] with file, line (CSV) or row (other formats) and column for anything that is not a recording of one
    /// run of such a machine.
    pub fn read(file: &Path, expected: Option<AxisKind>) -> Result<Self, Error> {
        let wanted = Wanted::Recording(expected);
        let (header, values) = log_file::read(file, wanted)?.columns(file, wanted)?;
        Self::assemble(file, header, values)
    }

    /// Reads a recording of `machine`, whose file may say what the columns of its logs are.
    ///
    /// # Errors
    ///
    /// As [`Recording::read`]; a column that the machine file names and the log does not have.
    pub fn of(file: &Path, machine: &Machine) -> Result<Self, Error> {
        Self::mapped(file, machine.axis.kind, &machine.columns)
    }

    /// Reads a recording from a log whose columns `mapping` names; the format's own where it is empty.
    ///
    /// # Errors
    ///
    /// As [`Recording::of`].
    pub fn mapped(file: &Path, axis: AxisKind, mapping: &Mapping) -> Result<Self, Error> {
        let wanted = Wanted::Mapped(axis, mapping);
        let (header, values) = log_file::read(file, wanted)?.columns(file, wanted)?;
        Self::assemble(file, header, values)
    }

    /// Reads a recording from the bytes of a CSV file; `file` names it in messages.
    ///
    /// # Errors
    ///
    /// As [`Recording::read`].
    pub fn from_csv_bytes(file: &Path, bytes: &[u8], expected: Option<AxisKind>) -> Result<Self, Error> {
        let (header, values) = csv_file::read(file, Cursor::new(bytes), Wanted::Recording(expected))?;
        Self::assemble(file, header, values)
    }

    /// Reads a recording from the bytes of a Parquet file; `file` names it in messages.
    ///
    /// # Errors
    ///
    /// As [`Recording::read`].
    pub fn from_parquet_bytes(file: &Path, bytes: &[u8], expected: Option<AxisKind>) -> Result<Self, Error> {
        let (header, values) = parquet_file::read(file, Bytes::copy_from_slice(bytes), Wanted::Recording(expected))?;
        Self::assemble(file, header, values)
    }

    /// Reads a recording from the bytes of a log of any format, which its first bytes tell; `file` names it in messages.
    ///
    /// # Errors
    ///
    /// As [`Recording::mapped`].
    pub fn from_bytes(file: &Path, bytes: &[u8], axis: AxisKind, mapping: &Mapping) -> Result<Self, Error> {
        let wanted = Wanted::Mapped(axis, mapping);
        let (header, values) = log_file::read_bytes(file, bytes, wanted)?.columns(file, wanted)?;
        Self::assemble(file, header, values)
    }
}
