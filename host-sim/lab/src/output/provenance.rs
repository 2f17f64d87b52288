//! What made an output: enough to make it again.

use std::fs::File;
use std::io;
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::{Outputs, mark};
use crate::Error;

/// The environment variable in place of the clock, in seconds since 1970, for outputs that are the same to the byte
/// (reproducible-builds.org).
pub const CLOCK: &str = "SOURCE_DATE_EPOCH";

/// What made an output. Two runs of one program on the same inputs differ in `date` alone.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// `Written by servo-lab` and its version: also how the tool knows the file as its own.
    pub written_by: String,
    /// Commit of the sources the program was built from, and whether they differed from it.
    pub commit: String,
    /// The command, quoted as a shell takes it.
    pub command: String,
    /// UTC, ISO 8601.
    pub date: String,
    /// Files that were read.
    pub inputs: Vec<Input>,
    /// What the random draws began with; none where nothing is drawn.
    pub seed: Option<u64>,
}

/// A file that was read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Input {
    /// As the user named it.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal; none of a pipe or a device, which can be read once only.
    pub sha256: Option<String>,
}

impl Provenance {
    /// Of this run, with the inputs it told.
    ///
    /// # Errors
    /// An input that can no longer be read.
    pub fn of(outputs: &Outputs, seed: Option<u64>) -> Result<Self, Error> {
        let input = |file: &std::path::PathBuf| {
            let sha256 = sha256(file).map_err(|error| Error::input(file, None, "", error.to_string()))?;
            Ok(Input { file: file.display().to_string(), sha256 })
        };
        Ok(Self {
            inputs: outputs.inputs().iter().map(input).collect::<Result<_, Error>>()?,
            ..Self::without_inputs(seed)
        })
    }

    /// Of this run, which reads no files.
    pub fn without_inputs(seed: Option<u64>) -> Self {
        let words: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
        let quoted = words.iter().map(|word| shlex::try_quote(word).map_or_else(|_| word.clone(), Into::into));
        let command = std::iter::once("servo-lab".to_owned()).chain(quoted).collect::<Vec<String>>().join(" ");
        Self {
            written_by: format!("{} {}", mark::WORDS, env!("CARGO_PKG_VERSION")),
            commit: env!("SERVO_LAB_COMMIT").to_owned(),
            command,
            date: humantime::format_rfc3339_seconds(now()).to_string(),
            inputs: Vec::new(),
            seed,
        }
    }
}

fn now() -> SystemTime {
    let fixed = std::env::var(CLOCK).ok().and_then(|seconds| seconds.parse().ok());
    // Later years have no place in the format.
    let fixed = fixed.filter(|seconds| *seconds < 253_402_300_800);
    fixed.map_or_else(SystemTime::now, |seconds| UNIX_EPOCH + Duration::from_secs(seconds))
}

/// SHA-256 of a file's bytes, hexadecimal; none of a pipe or a device, which can be read once only.
///
/// # Errors
/// A file that cannot be read.
pub fn sha256(file: &Path) -> io::Result<Option<String>> {
    // Standard input was read already.
    if file.as_os_str() == "-" || !std::fs::metadata(file)?.is_file() {
        return Ok(None);
    }
    let mut hasher = Sha256::new();
    io::copy(&mut File::open(file)?, &mut hasher)?;
    Ok(Some(hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()))
}
