//! A recording that is written while it comes in.

use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use tempfile::TempPath;

use super::{csv_recording, failed, place, temporary_beside};
use crate::Error;
use crate::Recording;

/// A CSV file that grows under a temporary name and takes its own when it is finished; dropped before, it is gone.
#[derive(Debug)]
pub struct Growing {
    file: PathBuf,
    target: PathBuf,
    to: BufWriter<File>,
    temporary: TempPath,
    has_header: bool,
}

impl Growing {
    /// Begins `file`, which must be, or become, a regular file.
    ///
    /// # Errors
    ///
    /// [`Error::Output`].
    pub fn create(file: &Path) -> Result<Self, Error> {
        let begin = || {
            let target = match fs::metadata(file) {
                Ok(there) if !there.is_file() => return Err(io::Error::other("it is there and not a regular file")),
                _ => place::resolved(file)?,
            };
            // In parts: together they name the temporary file in an error.
            let (to, temporary) = temporary_beside(&target)?.into_parts();
            Ok(Self { file: file.to_path_buf(), target, to: BufWriter::new(to), temporary, has_header: false })
        };
        begin().map_err(|error| failed(file, &error))
    }

    /// Adds the rows of `part`; its columns must be those of the part before.
    ///
    /// # Errors
    ///
    /// [`Error::Output`].
    pub fn append(&mut self, part: &Recording) -> Result<(), Error> {
        let write = if self.has_header { csv_recording::append } else { csv_recording::write };
        self.has_header = true;
        write(part, &mut self.to).map_err(|error| failed(&self.file, &error))
    }

    /// Gives the file its name; what stood there before is replaced.
    ///
    /// # Errors
    ///
    /// [`Error::Output`]; what stood there before is untouched then.
    pub fn finish(self) -> Result<(), Error> {
        let Self { file, target, to, temporary, .. } = self;
        to.into_inner().map_err(|error| failed(&file, error.error()))?;
        temporary.persist(target).map(drop).map_err(|error| failed(&file, &error.error))
    }
}
