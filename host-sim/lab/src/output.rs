//! Outputs: files, which appear whole or not at all, and standard output.

use std::io::{self, Write};
use std::path::PathBuf;

pub use recording::output::{Growing, folder, write, write_text};

use crate::Error;

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
