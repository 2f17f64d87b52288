//! Outputs appear whole or not at all.

use std::io::{BufWriter, Write};
use std::path::Path;

use crate::Error;

/// Writes `file` through `fill`: into a temporary file beside it, which takes its name once it is complete.
///
/// # Errors
/// [`Error::Output`]; what stood there before is untouched then.
pub fn write(
    file: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut std::fs::File>) -> std::io::Result<()>,
) -> Result<(), Error> {
    let failed = |error: std::io::Error| Error::Output { file: file.to_path_buf(), reason: error.to_string() };
    let folder = match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut temporary = tempfile::Builder::new().prefix(".servo-lab-").tempfile_in(folder).map_err(failed)?;
    let mut buffered = BufWriter::new(temporary.as_file_mut());
    fill(&mut buffered).and_then(|()| buffered.flush()).map_err(failed)?;
    drop(buffered);
    temporary.persist(file).map(|_| ()).map_err(|error| failed(error.error))
}

/// Makes a folder for outputs, and those above it.
///
/// # Errors
/// [`Error::Output`].
pub fn folder(folder: &Path) -> Result<(), Error> {
    let failed = |error: std::io::Error| Error::Output { file: folder.to_path_buf(), reason: error.to_string() };
    std::fs::create_dir_all(folder).map_err(failed)
}
