//! Outputs: files, which appear whole or not at all, and standard output.
//!
//! A command tells [`Files`] what it reads and writes before it computes; texts get the tool's mark from [`formats`], and JSON
//! and HTML their [`Provenance`].

pub mod formats;
mod provenance;

use std::io::{self, Write};
use std::path::PathBuf;

pub use provenance::{CLOCK, Input, Provenance, sha256};
pub use recording::output::{Files, Growing, Output, Outputs, folder, mark, write, write_text};

use crate::Error;
use crate::plot::Figure;

/// Writes a figure as SVG with the tool's mark; it appears with [`Outputs::finish`].
///
/// # Errors
///
/// As [`Outputs::write`].
pub fn figure(outputs: &mut Outputs, output: Output, figure: &Figure) -> Result<(), Error> {
    let failed = |reason| Error::Output { file: outputs.file(output).to_path_buf(), reason };
    let svg = figure.to_svg().map_err(failed)?;
    text(outputs, output, &formats::markup(&svg))
}

/// Writes a text as it is; it appears with [`Outputs::finish`].
///
/// # Errors
///
/// As [`Outputs::write`].
pub fn text(outputs: &mut Outputs, output: Output, text: &str) -> Result<(), Error> {
    outputs.write(output, |to| to.write_all(text.as_bytes()))
}

/// Writes `text` to standard output. A reader that went away, as `head` does, is no error.
///
/// # Errors
///
/// [`Error::Output`] where standard output cannot be written.
pub fn print(text: &str) -> Result<(), Error> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::Output { file: PathBuf::from("standard output"), reason: error.to_string() })
        }
        _ => Ok(()),
    }
}
