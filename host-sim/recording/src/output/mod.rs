//! Outputs appear whole or not at all: each is written to a temporary file in its folder, which then takes its name.
//!
//! [`Files`] is how a command comes to write: it is told all inputs and outputs first, and refuses what would lose a file.

mod csv_recording;
mod files;
mod growing;
pub mod mark;
mod mcap_recording;
mod parquet_recording;
mod place;

pub use files::{Files, Output, Outputs};
pub use growing::Growing;

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::Error;
use crate::{Machine, Recording};

/// Writes `file` through `fill`, in a folder that is made if it is not there.
///
/// A symbolic link stays and the file it points to is replaced; a pipe or a device, which cannot be replaced, is written
/// into.
///
/// # Errors
///
/// [`Error::Output`]; what stood in `file` before is untouched then.
pub fn write(file: &Path, fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> Result<(), Error> {
    Staged::new(file, fill)?.finish()
}

/// Writes `text` to `file`, as [`write()`] does.
///
/// # Errors
///
/// As [`write()`].
pub fn write_text(file: &Path, text: &str) -> Result<(), Error> {
    write(file, |to| to.write_all(text.as_bytes()))
}

/// Makes a folder for outputs, and those above it.
///
/// # Errors
///
/// [`Error::Output`].
pub fn folder(folder: &Path) -> Result<(), Error> {
    fs::create_dir_all(folder).map_err(|error| failed(folder, &error))
}

/// A file whose content is written and whose name it does not have yet; dropped, it is gone.
#[derive(Debug)]
struct Staged {
    file: PathBuf,
    /// None for a pipe or a device, which has its content already.
    to: Option<(NamedTempFile, PathBuf)>,
}

impl Staged {
    /// Writes the content of `file` through `fill`.
    fn new(file: &Path, fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> Result<Self, Error> {
        let write = || {
            let to = match fs::metadata(file) {
                Ok(there) if there.is_dir() => return Err(io::Error::other("it is a folder")),
                Ok(there) if !there.is_file() => {
                    fill_and_flush(&mut OpenOptions::new().write(true).open(file)?, fill)?;
                    None
                }
                _ => {
                    let target = place::resolved(file)?;
                    let mut temporary = temporary_beside(&target)?;
                    fill_and_flush(temporary.as_file_mut(), fill)?;
                    Some((temporary, target))
                }
            };
            Ok(Self { file: file.to_path_buf(), to })
        };
        write().map_err(|error| failed(file, &error))
    }

    /// Gives the file its name.
    fn finish(self) -> Result<(), Error> {
        let Some((temporary, target)) = self.to else { return Ok(()) };
        temporary.persist(target).map(drop).map_err(|error| failed(&self.file, &error.error))
    }
}

fn fill_and_flush(file: &mut File, fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> io::Result<()> {
    let mut buffered = BufWriter::new(file);
    fill(&mut buffered)?;
    buffered.flush()
}

/// An empty file in the folder of `target`, which is made: a rename is atomic within one file system only.
fn temporary_beside(target: &Path) -> io::Result<NamedTempFile> {
    let folder = place::folder_of(target);
    place::make_folder(&folder)?;
    // Opened here, as any new file: readable by others unless the user's mask says otherwise, where a temporary file is not; and
    // an error does not name it.
    let open = |file: &Path| OpenOptions::new().read(true).write(true).create_new(true).open(file);
    tempfile::Builder::new().prefix(".servo-lab-").make_in(folder, open)
}

/// What went wrong with `file`, by the name the user gave it.
fn failed(file: &Path, error: &io::Error) -> Error {
    let below = error.get_ref().and_then(|inner| inner.source()).map(ToString::to_string);
    let reason = below.unwrap_or_else(|| error.to_string()).replace('\n', " ");
    Error::Output { file: file.to_path_buf(), reason }
}

impl Recording {
    /// The recording as CSV text, for standard output.
    ///
    /// # Errors
    ///
    /// [`Error::Output`], if memory is all.
    pub fn to_csv(&self) -> Result<String, Error> {
        let mut text = Vec::new();
        let failed = |reason: String| Error::Output { file: PathBuf::from("standard output"), reason };
        csv_recording::write(self, &mut text).map_err(|error| failed(error.to_string()))?;
        String::from_utf8(text).map_err(|error| failed(error.to_string()))
    }

    /// Writes the recording, as the extension of `file` says: `.csv`, `.parquet` or `.mcap`. Every number reads back to the
    /// same bits (of MCAP, whole numbers up to 2^53). Units follow the axis; gaps stay missing rows.
    ///
    /// # Errors
    ///
    /// [`Error::Output`]; what stood in `file` before is untouched then.
    pub fn write(&self, file: &Path) -> Result<(), Error> {
        self.stage(file)?.finish()
    }

    fn stage(&self, file: &Path) -> Result<Staged, Error> {
        let extension = file.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
        match extension.as_deref() {
            Some("csv") => Staged::new(file, |to| csv_recording::write(self, to)),
            Some("parquet") => Staged::new(file, |to| parquet_recording::write(self, to).map_err(io::Error::other)),
            Some("mcap") => Staged::new(file, |to| mcap_recording::write(self, to).map_err(io::Error::other)),
            _ => {
                let reason = "the name of a recording must end in .csv, .parquet or .mcap".to_owned();
                Err(Error::Output { file: file.to_path_buf(), reason })
            }
        }
    }
}

impl Machine {
    /// Writes the machine file; reading it gives the same machine.
    ///
    /// # Errors
    ///
    /// [`Error::Output`]; what stood in `file` before is untouched then.
    pub fn write(&self, file: &Path) -> Result<(), Error> {
        write(file, |to| to.write_all(self.to_toml().map_err(io::Error::other)?.as_bytes()))
    }
}
