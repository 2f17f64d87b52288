//! Cases run: seals first, then files, then the diagnosis in a process of its own.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::Outcome;
use super::case::{Case, Files};
use crate::progress::Progress;
use crate::report::Answer;
use crate::{Error, output};

/// How often a running diagnosis is looked at.
const POLL: Duration = Duration::from_millis(50);

/// How to run.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Folder of cases, seals and outcomes.
    pub out: PathBuf,
    /// Threads of each diagnosis.
    pub jobs: usize,
    /// Diagnoses at a time.
    pub workers: usize,
    /// Keep the recordings.
    pub keep: bool,
    /// Fit the true structure too.
    pub oracle: bool,
    /// A diagnosis that takes longer is ended, and its case counts as not run.
    pub limit: Duration,
}

/// Writes the seals of the cases; gives the hash over all of them, which commits to every truth.
///
/// # Errors
/// A file that cannot be written.
pub fn seal(seeds: &[u64], settings: &Settings) -> Result<String, Error> {
    let folder = settings.out.join("sealed");
    output::folder(&folder)?;
    let mut hashes = String::new();
    for &seed in seeds {
        let (text, hash) = sealed(&Case::draw(seed))?;
        output::write_text(&folder.join(format!("{seed}.json")), &text)?;
        hashes.push_str(&format!("{hash}  {seed}.json\n"));
    }
    output::write_text(&folder.join("SHA256SUMS"), &hashes)?;
    Ok(conceal::seal::hash(hashes.as_bytes()))
}

fn sealed(case: &Case) -> Result<(String, String), Error> {
    case.truth.seal().map_err(|error| Error::Usage(format!("seed {}: {error}", case.seed)))
}

/// Runs the cases that have no outcome yet. A case that fails does not stop the others: its seed and reason are given.
///
/// # Errors
/// A folder that cannot be made, threads that cannot be started.
pub fn run(seeds: &[u64], settings: &Settings) -> Result<Vec<Result<Outcome, String>>, Error> {
    output::folder(&settings.out.join("outcomes"))?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.workers).build();
    let pool = pool.map_err(|error| Error::Usage(format!("--workers: {error}")))?;
    let progress = Progress::new("cases", seeds.len() as u64);
    let one = |&seed: &u64| {
        let outcome = resumed(seed, settings).map_or_else(|| case(seed, settings), Ok);
        progress.advance(1);
        outcome.map_err(|error| format!("seed {seed}: {error}"))
    };
    Ok(pool.install(|| seeds.par_iter().map(one).collect()))
}

/// The outcome of an earlier run, if it is of the same truth.
fn resumed(seed: u64, settings: &Settings) -> Option<Outcome> {
    let outcome = read(&outcome_file(seed, settings)).ok()?;
    (outcome.hash == sealed(&Case::draw(seed)).ok()?.1).then_some(outcome)
}

fn outcome_file(seed: u64, settings: &Settings) -> PathBuf {
    settings.out.join("outcomes").join(format!("{seed}.json"))
}

/// Reads one outcome.
///
/// # Errors
/// A file that is none.
pub fn read(file: &Path) -> Result<Outcome, Error> {
    let unreadable = |message: String| Error::input(file, None, "", message);
    let text = std::fs::read_to_string(file).map_err(|error| unreadable(error.to_string()))?;
    serde_json::from_str(&text).map_err(|error| unreadable(error.to_string()))
}

fn case(seed: u64, settings: &Settings) -> Result<Outcome, Error> {
    let case = Case::draw(seed);
    let (_, hash) = sealed(&case)?;
    let (blueprint, truth) = (case.blueprint.clone(), case.truth.clone());
    let folder = settings.out.join("cases").join(seed.to_string());
    let files = case.write(&folder)?;
    let without = if blueprint.arm == super::Arm::Removed { blueprint.effects.join(",") } else { String::new() };
    let started = Instant::now();
    let answer = diagnose(&files, &folder.join("answer.json"), &["--without", &without], settings)?;
    let seconds = started.elapsed().as_secs_f64();
    let mut outcome = Outcome::of(blueprint.arm, blueprint.size, truth, hash, &answer, seconds);
    if settings.oracle && blueprint.arm.nameable() {
        let only = blueprint.effects.join(",");
        let oracle = diagnose(&files, &folder.join("oracle.json"), &["--only", &only], settings)?;
        outcome.heldout_over_oracle = Some(answer.fit.heldout_after_rms / oracle.fit.heldout_after_rms);
    }
    let text = serde_json::to_string_pretty(&outcome).map_err(|error| Error::Usage(error.to_string()))?;
    output::write_text(&outcome_file(seed, settings), &text)?;
    if !settings.keep {
        // Recordings come back from the seed; failing to remove them loses nothing.
        let _ = std::fs::remove_dir_all(&folder);
    }
    Ok(outcome)
}

/// Runs `servo-lab diagnose` on the files, and on nothing else.
fn diagnose(files: &Files, json: &Path, names: &[&str; 2], settings: &Settings) -> Result<Answer, Error> {
    let program =
        std::env::current_exe().map_err(|error| Error::Usage(format!("the tool cannot find itself: {error}")))?;
    let mut command = Command::new(program);
    command.arg("diagnose").arg("--machine").arg(&files.machine).arg("--holdout").arg(&files.holdout);
    command.arg("--json").arg(json).arg("--jobs").arg(settings.jobs.to_string());
    if !names[1].is_empty() {
        command.args(names);
    }
    let started = |error: std::io::Error| Error::Usage(format!("diagnose cannot be started: {error}"));
    let errors = json.with_extension("stderr");
    command.args(&files.recordings).stdin(Stdio::null()).stdout(Stdio::null());
    let child = command.stderr(File::create(&errors).map_err(started)?).spawn().map_err(started)?;
    let status = finish(child, settings.limit)?;
    if !status.success() {
        let said = std::fs::read_to_string(&errors).unwrap_or_default();
        return Err(Error::Usage(format!("diagnose ended with {status}: {}", said.trim())));
    }
    let unreadable = |message: String| Error::input(json, None, "", message);
    let text = std::fs::read_to_string(json).map_err(|error| unreadable(error.to_string()))?;
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
