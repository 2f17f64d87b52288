//! The one error of the tool: a sentence the user can act on, and the exit code it means.

use std::path::{Path, PathBuf};

/// Why a command stopped. None of the reasons is a panic.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that was read is not what it must be.
    #[error("{}{}{}: {message}", file.display(), at_line(*line), at_key(key))]
    Input {
        /// The file as the user named it.
        file: PathBuf,
        /// One-based line, where one is known.
        line: Option<u64>,
        /// Key or column the message is about; empty where none is.
        key: String,
        /// What is wrong, what is allowed, what was nearest.
        message: String,
    },
    /// A flag or a combination of flags that cannot be carried out.
    #[error("{0}")]
    Usage(String),
    /// An output that could not be written; the file there before is untouched.
    #[error("{}: cannot write: {reason}", file.display())]
    Output {
        /// Where the output was to go.
        file: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// The drive was asked and said no, or did not do it.
    #[error("{place}: {message}")]
    Refused {
        /// Port or address as the user named it.
        place: String,
        /// Why, and what to do.
        message: String,
    },
    /// No connection to a drive or a probe, or one that broke.
    #[error("{place}: {message}")]
    Connection {
        /// Port, address or probe as the user named it.
        place: String,
        /// What happened, and what to look at.
        message: String,
    },
}

impl Error {
    /// An error about `file`, optionally at a one-based `line` and a `key` or column (empty for none).
    pub fn input(file: &Path, line: Option<u64>, key: &str, message: impl Into<String>) -> Self {
        Self::Input { file: file.to_path_buf(), line, key: key.to_owned(), message: message.into() }
    }

    /// An error about the connection to `place`.
    pub fn connection(place: &str, message: impl ToString) -> Self {
        Self::Connection { place: place.to_owned(), message: message.to_string() }
    }

    /// Process exit code: 2 for input that cannot be read, flags that cannot be followed and outputs that cannot be written, 3
    /// for what a drive refused, 4 for no connection. 1 is no error: it tells a script the verdict it asked about.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Input { .. } | Self::Usage(_) | Self::Output { .. } => 2,
            Self::Refused { .. } => 3,
            Self::Connection { .. } => 4,
        }
    }
}

fn at_line(line: Option<u64>) -> String {
    line.map_or_else(String::new, |line| format!(":{line}"))
}

fn at_key(key: &str) -> String {
    if key.is_empty() { String::new() } else { format!(": {key}") }
}
