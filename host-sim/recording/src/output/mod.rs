//! Outputs appear whole or not at all: each is written to a temporary file in its folder, which then takes its name.

mod csv_recording;
mod growing;
mod parquet_recording;

pub use growing::Growing;

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::Error;
use crate::{Machine, Recording};

/// Writes `file` through `fill`.
///
/// A symbolic link stays and the file it points to is replaced; a pipe or a device, which cannot be replaced, is written
/// into.
///
/// # Errors
///
/// [`Error::Output`]; what stood in `file` before is untouched then.
pub fn write(file: &Path, fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> Result<(), Error> {
    write_whole(file, fill)
        .map_err(|error| Error::Output { file: file.to_path_buf(), reason: one_line(&error.to_string()) })
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
    let failed = |error: io::Error| Error::Output { file: folder.to_path_buf(), reason: one_line(&error.to_string()) };
    fs::create_dir_all(folder).map_err(failed)
}

fn write_whole(file: &Path, fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> io::Result<()> {
    let target = match fs::metadata(file) {
        Ok(there) if there.is_dir() => return Err(io::Error::other("it is a folder")),
        Ok(there) if !there.is_file() => return fill_and_flush(&mut OpenOptions::new().write(true).open(file)?, fill),
        Ok(_) => fs::canonicalize(file)?,
        Err(_) => file.to_path_buf(),
    };
    let mut temporary = temporary_beside(&target)?;
    fill_and_flush(temporary.as_file_mut(), fill)?;
    temporary.persist(&target).map(drop).map_err(|error| error.error)
}

fn fill_and_flush(file: &mut File, fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>) -> io::Result<()> {
    let mut buffered = BufWriter::new(file);
    fill(&mut buffered)?;
    buffered.flush()
}

/// An empty file in the folder of `target`: a rename is atomic within one file system only.
fn temporary_beside(target: &Path) -> io::Result<tempfile::NamedTempFile> {
    let folder =
        target.parent().filter(|folder| !folder.as_os_str().is_empty()).map_or(PathBuf::from("."), PathBuf::from);
    let mut builder = tempfile::Builder::new();
    builder.prefix(".servo-lab-");
    // As any new file: readable by others unless the user's mask says otherwise, where a temporary file is not.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

fn one_line(message: &str) -> String {
    message.replace('\n', " ")
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

    /// Writes the recording, as the extension of `file` says: `.csv` or `.parquet`. Every number reads back to the same
    /// bits. Units follow the axis; gaps stay missing rows.
    ///
    /// # Errors
    ///
    /// [`Error::Output`]; what stood in `file` before is untouched then.
    pub fn write(&self, file: &Path) -> Result<(), Error> {
        let extension = file.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
        match extension.as_deref() {
            Some("csv") => write(file, |to| csv_recording::write(self, to)),
            Some("parquet") => write(file, |to| parquet_recording::write(self, to).map_err(io::Error::other)),
            _ => {
                let reason = "the name of a recording must end in .csv or .parquet".to_owned();
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
