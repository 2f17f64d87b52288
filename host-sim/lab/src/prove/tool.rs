//! The tool under test, as a process of its own that is given files and nothing else.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::Answer;
use crate::Error;

/// How often a running diagnosis is looked at.
const POLL: Duration = Duration::from_millis(50);

/// How the tool is run.
#[derive(Debug, Clone)]
pub struct Tool {
    /// Program; takes `diagnose` as its first word.
    pub program: PathBuf,
    /// Threads of each diagnosis.
    pub jobs: usize,
    /// A diagnosis that takes longer is ended, and its case counts as not answered.
    pub limit: Duration,
}

/// What a diagnosis is asked. Names of files are relative to the folder it runs in, so that nothing but their content
/// can tell what they are.
#[derive(Debug, Clone, Default)]
pub struct Question<'a> {
    /// Nominal model.
    pub machine: &'a str,
    /// Recordings to fit.
    pub recordings: Vec<&'a str>,
    /// Recordings held out.
    pub holdout: Vec<&'a str>,
    /// Only these effects; all if empty.
    pub only: Vec<&'a str>,
    /// None of these effects.
    pub without: Vec<&'a str>,
    /// Writes the improved model there, believed or not.
    pub model: Option<&'a str>,
}

impl Tool {
    /// Asks in a folder; the answer stays there as `NAME.json`, the reference it proposes, if any, as
    /// `NAME.experiment.csv`.
    ///
    /// # Errors
    /// A process that cannot be started, fails or does not end in time; an answer that is none.
    pub fn ask(&self, folder: &Path, name: &str, question: &Question<'_>) -> Result<Answer, Error> {
        let file = format!("{name}.json");
        let mut command = Command::new(&self.program);
        command.current_dir(folder).args(["diagnose", "--machine", question.machine, "--json", &file]);
        command.arg("--jobs").arg(self.jobs.to_string());
        command.args(["--experiment", &format!("{name}.experiment.csv")]);
        for held_out in &question.holdout {
            command.args(["--holdout", held_out]);
        }
        for (flag, ids) in [("--only", &question.only), ("--without", &question.without)] {
            if !ids.is_empty() {
                command.arg(flag).arg(ids.join(","));
            }
        }
        if let Some(model) = question.model {
            command.args(["--write-model", model, "--force"]);
        }
        let started = |error: std::io::Error| {
            Error::Usage(format!("{} diagnose cannot be started: {error}", self.program.display()))
        };
        let errors = folder.join(format!("{name}.stderr"));
        command.args(&question.recordings).stdin(Stdio::null()).stdout(Stdio::null());
        let child = command.stderr(File::create(&errors).map_err(started)?).spawn().map_err(started)?;
        let status = finish(child, self.limit)?;
        if !status.success() {
            let said = std::fs::read_to_string(&errors).unwrap_or_default();
            return Err(Error::Usage(format!("diagnose ended with {status}: {}", said.trim())));
        }
        read_json(&folder.join(file))
    }
}

/// Reads a JSON file of any kind.
///
/// # Errors
/// A file that is none of that kind.
pub fn read_json<T: serde::de::DeserializeOwned>(file: &Path) -> Result<T, Error> {
    let unreadable = |message: String| Error::input(file, None, "", message);
    let text = std::fs::read_to_string(file).map_err(|error| unreadable(error.to_string()))?;
    serde_json::from_str(&text).map_err(|error| unreadable(error.to_string()))
}

/// Waits for the process, and ends it at the limit.
fn finish(mut child: Child, limit: Duration) -> Result<ExitStatus, Error> {
    let begun = Instant::now();
    let failed = |error: std::io::Error| Error::Usage(format!("diagnose cannot be waited for: {error}"));
    loop {
        if let Some(status) = child.try_wait().map_err(failed)? {
            return Ok(status);
        }
        if begun.elapsed() >= limit {
            child.kill().map_err(failed)?;
            child.wait().map_err(failed)?;
            return Err(Error::Usage(format!("diagnose was ended after {} s", limit.as_secs())));
        }
        std::thread::sleep(POLL);
    }
}
