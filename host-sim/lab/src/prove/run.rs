//! Cases run: seals first, then files, then the diagnosis, then the judgement.

use std::path::{Path, PathBuf};
use std::time::Instant;

use conceal::case::{EXPERIMENT, HELD_OUT, MACHINE};
use conceal::plan::{Arm, Version};
use conceal::subject::Subject;
use rayon::prelude::*;

use super::judge::{After, nameable};
use super::tool::{Question, Tool, read_json};
use super::{Answer, Outcome, folder, rivals};
use crate::progress::Progress;
use crate::{Error, output};

/// How to run.
#[derive(Debug, Clone)]
pub struct Settings {
    /// How seeds are read.
    pub plan: Version,
    /// Folder of cases, seals and outcomes.
    pub out: PathBuf,
    /// The tool under test.
    pub tool: Tool,
    /// Cases at a time.
    pub workers: usize,
    /// Keep the recordings.
    pub keep: bool,
    /// Fit the true structure too.
    pub oracle: bool,
    /// Run the rivals too.
    pub rivals: bool,
}

/// Outcomes, and the seeds that gave none with the reason.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ran {
    /// By seed.
    pub outcomes: Vec<Outcome>,
    /// Seed and reason.
    pub failures: Vec<(u64, String)>,
}

/// A seed that gave no case, with the reason.
type Failure = (u64, String);

/// Writes the seals of the cases; gives the cases, and the hash over all seals, which commits to every truth. A seed that gives no
/// case is among the failures.
///
/// # Errors
/// A file that cannot be written.
pub fn seal(seeds: &[u64], settings: &Settings) -> Result<(Vec<Subject>, Vec<Failure>, String), Error> {
    let folder = settings.out.join("sealed");
    output::folder(&folder)?;
    let draw = |&seed: &u64| Subject::draw(settings.plan, seed).map_err(|error| (seed, error.to_string()));
    let drawn: Vec<_> = pool(settings)?.install(|| seeds.par_iter().with_max_len(1).map(draw).collect());
    let (mut cases, mut failures, mut hashes) = (Vec::new(), Vec::new(), String::new());
    for case in drawn {
        match case {
            Ok(case) => {
                let (text, hash) = sealed(&case)?;
                output::write_text(&folder.join(format!("{}.json", case.seed())), &text)?;
                hashes.push_str(&format!("{hash}  {}.json\n", case.seed()));
                cases.push(case);
            }
            Err(failure) => failures.push(failure),
        }
    }
    output::write_text(&folder.join("SHA256SUMS"), &hashes)?;
    Ok((cases, failures, conceal::seal::hash(hashes.as_bytes())))
}

fn pool(settings: &Settings) -> Result<rayon::ThreadPool, Error> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.workers).build();
    pool.map_err(|error| Error::Usage(format!("--workers: {error}")))
}

fn sealed(case: &Subject) -> Result<(String, String), Error> {
    case.truth().seal().map_err(|error| of_seed(case.seed(), &error))
}

fn of_seed(seed: u64, error: &conceal::Error) -> Error {
    Error::Usage(format!("seed {seed}: {error}"))
}

/// Writes the files of cases with their truth opened, `ARM/SEED/` each, and diagnoses nothing.
///
/// # Errors
/// A drive that trips, a file that cannot be written.
pub fn write_only(seeds: &[u64], plan: Version, out: &Path) -> Result<(), Error> {
    let progress = Progress::new("cases", seeds.len() as u64);
    for &seed in seeds {
        let case = Subject::draw(plan, seed).map_err(|error| of_seed(seed, &error))?;
        let folder = folder::case(out, case.truth().arm, seed);
        output::folder(&folder)?;
        case.write(&folder).map_err(|error| of_seed(seed, &error))?;
        output::write_text(&folder.join("truth.json"), &sealed(&case)?.0)?;
        progress.advance(1);
    }
    Ok(())
}

/// Runs the cases that have no outcome yet. A case that fails does not stop the others.
///
/// # Errors
/// A folder that cannot be made, threads that cannot be started.
pub fn run(cases: &[Subject], settings: &Settings) -> Result<Ran, Error> {
    output::folder(&settings.out.join("outcomes"))?;
    output::folder(&settings.out.join("failures"))?;
    let progress = Progress::new("cases", cases.len() as u64);
    let one = |case: &Subject| {
        let outcome = resumed(case, settings).map_or_else(|| recorded(case, settings), Ok);
        progress.advance(1);
        outcome.map_err(|error| (case.seed(), error.to_string()))
    };
    // One case at a time to each worker: they take very unequal times.
    let results: Vec<_> = pool(settings)?.install(|| cases.par_iter().with_max_len(1).map(one).collect());
    let mut ran = Ran::default();
    for result in results {
        match result {
            Ok(outcome) => ran.outcomes.push(outcome),
            Err(failure) => ran.failures.push(failure),
        }
    }
    Ok(ran)
}

/// The outcome of an earlier run, if it is of the same truth.
fn resumed(case: &Subject, settings: &Settings) -> Option<Outcome> {
    let outcome: Outcome = read_json(&outcome_file(case.seed(), settings)).ok()?;
    (outcome.hash == sealed(case).ok()?.1).then_some(outcome)
}

fn outcome_file(seed: u64, settings: &Settings) -> PathBuf {
    settings.out.join("outcomes").join(format!("{seed}.json"))
}

/// Runs a case and writes what came of it, so that a merge and a later run find it.
fn recorded(subject: &Subject, settings: &Settings) -> Result<Outcome, Error> {
    let seed = subject.seed();
    let failure = settings.out.join("failures").join(format!("{seed}.txt"));
    match case(subject, settings) {
        Ok(outcome) => {
            let text = serde_json::to_string_pretty(&outcome).map_err(|error| Error::Usage(error.to_string()))?;
            output::write_text(&outcome_file(seed, settings), &text)?;
            // That of an earlier run, if there is one.
            let _ = std::fs::remove_file(&failure);
            Ok(outcome)
        }
        Err(error) => {
            output::write_text(&failure, &error.to_string())?;
            Err(error)
        }
    }
}

fn case(case: &Subject, settings: &Settings) -> Result<Outcome, Error> {
    let (_, hash) = sealed(case)?;
    let (seed, truth) = (case.seed(), case.truth());
    let folder = settings.out.join("cases").join(seed.to_string());
    let is_kept = settings.keep || folder.exists();
    output::folder(&folder)?;
    case.write(&folder).map_err(|error| of_seed(seed, &error))?;
    let effects = case.effects();
    let removed = if truth.arm == Arm::Removed { effects.clone() } else { Vec::new() };
    let question = Question {
        machine: MACHINE,
        recordings: case.fitted().to_vec(),
        holdout: vec![HELD_OUT],
        without: removed,
        ..Question::default()
    };
    let started = Instant::now();
    let answer = settings.tool.ask(&folder, "answer", &question)?;
    let mut outcome = Outcome::of(truth.clone(), hash, &answer, started.elapsed().as_secs_f64());
    if truth.arm == Arm::Poor {
        outcome.after = after(case, &folder, &question, &answer, settings)?;
    } else if settings.oracle && nameable(truth) {
        let oracle = settings.tool.ask(&folder, "oracle", &Question { only: effects.clone(), ..question })?;
        let errors = answer.fit.heldout_after_rms.zip(oracle.fit.heldout_after_rms);
        outcome.heldout_over_oracle = errors.map(|(found, best)| found / best).filter(|ratio| ratio.is_finite());
    }
    if settings.rivals {
        outcome.rivals = rivals::answers(&folder, MACHINE, case.fitted(), HELD_OUT, truth)?;
    }
    if !is_kept {
        // What an earlier run kept stays. Recordings come back from the seed; failing to remove them loses nothing.
        let _ = std::fs::remove_dir_all(&folder);
    }
    Ok(outcome)
}

/// Plays the experiment the answer proposes on the same machine, and asks again with its recordings added.
fn after(
    case: &Subject,
    folder: &Path,
    before: &Question<'_>,
    answer: &Answer,
    settings: &Settings,
) -> Result<Option<After>, Error> {
    let Some(file) = answer.experiment.as_ref().and_then(|experiment| experiment.reference_csv.as_ref()) else {
        return Ok(None);
    };
    let file = folder.join(file);
    let unreadable = |error: std::io::Error| Error::input(&file, None, "", error.to_string());
    let reference = std::fs::read_to_string(&file).map_err(unreadable)?;
    case.write_experiment(&reference, folder).map_err(|error| of_seed(case.seed(), &error))?;
    let mut question = before.clone();
    question.recordings.push(EXPERIMENT[0]);
    question.holdout.push(EXPERIMENT[1]);
    Ok(Some(After::of(case.truth(), &settings.tool.ask(folder, "after", &question)?)))
}

/// The outcomes and failures that lie in these folders, by seed; an outcome counts over a failure.
///
/// # Errors
/// A folder or a file that cannot be read.
pub fn merged(folders: &[PathBuf]) -> Result<Ran, Error> {
    let mut ran = Ran::default();
    for file in to_merge(folders)? {
        if file.extension().is_some_and(|found| found == "json") {
            ran.outcomes.push(read_json(&file)?);
        } else {
            let seed = file.file_stem().and_then(|name| name.to_str()).and_then(|name| name.parse().ok());
            let reason = std::fs::read_to_string(&file).unwrap_or_default();
            ran.failures.extend(seed.map(|seed| (seed, reason)));
        }
    }
    ran.outcomes.sort_by_key(|outcome| outcome.truth.seed);
    ran.outcomes.dedup_by_key(|outcome| outcome.truth.seed);
    ran.failures.retain(|(seed, _)| ran.outcomes.binary_search_by_key(seed, |outcome| outcome.truth.seed).is_err());
    ran.failures.sort();
    ran.failures.dedup_by_key(|(seed, _)| *seed);
    Ok(ran)
}

/// The files of outcomes and failures that lie in these folders.
///
/// # Errors
/// A folder that cannot be read.
pub fn to_merge(folders: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let mut all = Vec::new();
    for folder in folders {
        all.extend(files(&folder.join("outcomes"), "json")?);
        all.extend(files(&folder.join("failures"), "txt")?);
    }
    // A folder lists its files in any order.
    all.sort();
    Ok(all)
}

fn files(folder: &Path, extension: &str) -> Result<Vec<PathBuf>, Error> {
    let unreadable = |error: std::io::Error| Error::input(folder, None, "", error.to_string());
    let entries: Result<Vec<_>, _> = std::fs::read_dir(folder).map_err(unreadable)?.collect();
    let paths = entries.map_err(unreadable)?.into_iter().map(|entry| entry.path());
    Ok(paths.filter(|file| file.extension().is_some_and(|found| found == extension)).collect())
}
