//! Recordings read from files and bytes of any format.

use std::ffi::OsStr;
use std::io::Cursor;
use std::path::Path;

use bytes::Bytes;

use super::{AxisKind, Recording, csv_file, parquet_file};
use crate::Error;

impl Recording {
    /// Reads the recording in `file`, by its extension: `.csv`, or `.parquet` with the same columns.
    ///
    /// `expected` is the axis of the machine the recording is of; without one the axis follows the units of the columns.
    ///
    /// # Errors
    ///
    /// [`Error::Input`] with file, line (CSV) or row (Parquet) and column for anything that is not a recording of one
    /// run of such a machine.
    pub fn read(file: &Path, expected: Option<AxisKind>) -> Result<Self, Error> {
        let extension = file.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
        match extension.as_deref() {
            Some("csv") => csv_file::read(file, expected),
            Some("parquet") => parquet_file::read(file, expected),
            _ => Err(Error::input(file, None, "", "is not a recording by its name: .csv or .parquet")),
        }
    }

    /// Reads a recording from the bytes of a CSV file; `file` names it in messages.
    ///
    /// # Errors
    ///
    /// As [`Recording::read`].
    pub fn from_csv_bytes(file: &Path, bytes: &[u8], expected: Option<AxisKind>) -> Result<Self, Error> {
        csv_file::read_from(file, Cursor::new(bytes), expected)
    }

    /// Reads a recording from the bytes of a Parquet file; `file` names it in messages.
    ///
    /// # Errors
    ///
    /// As [`Recording::read`].
    pub fn from_parquet_bytes(file: &Path, bytes: &[u8], expected: Option<AxisKind>) -> Result<Self, Error> {
        parquet_file::read_from(file, Bytes::copy_from_slice(bytes), expected)
    }
}
