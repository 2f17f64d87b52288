//! Real machines, each with known effects hidden from its nominal model: one recording after another is held out; the answer stands
//! beside what is known, and the written model beside a least-squares fit on windows that neither has seen.

mod least_squares;
pub(crate) mod sets;
mod windows;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::sets::{Known, MODELS, Model};
use self::windows::{HORIZONS_S, Simulated};
use super::text::Table;
use super::tool::{Question, Tool, read_json};
use super::{Answer, Verdict};
use crate::progress::Progress;
use crate::read::{Machine, Recording};
use crate::{Error, output};

/// An order a revolution is that of a known cogging within this.
const SAME_ORDER: f64 = 0.25;

/// What is asked of the real machines.
#[derive(Debug, Clone)]
pub struct Asked {
    /// Folders of sets; all if empty.
    pub sets: Vec<String>,
    /// Recordings held out of each, one after another; none for all.
    pub folds: Option<usize>,
    /// Cases at a time.
    pub workers: usize,
}

/// One recording held out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Fold {
    /// The recording.
    pub held_out: String,
    /// The tool's conclusion.
    pub verdict: Verdict,
    /// Names, by evidence.
    pub named: Vec<String>,
    /// For each known value: estimate and 95 % interval; none where the answer has no such parameter.
    pub answered: Vec<Option<[f64; 3]>>,
    /// Root mean square that windows of either length leave, in the unit of the position: nominal model, written model, least
    /// squares.
    pub left: [[Option<f64>; 3]; 2],
    /// Effects of the written model that the windows are simulated without.
    #[serde(default)]
    pub without: BTreeSet<String>,
    /// Time the diagnosis took, s.
    pub seconds: f64,
}

/// What came of one nominal model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RealOutcome {
    /// Set and machine file.
    pub name: String,
    /// What the nominal model leaves out.
    pub hidden: String,
    /// What is known: effect and parameter, range, source.
    pub known: Vec<(String, [f64; 2], String)>,
    /// Recording by recording.
    pub folds: Vec<Fold>,
}

/// Runs every model whose data is in the folder; says of the others why there is no answer.
///
/// # Errors
/// Threads that cannot be started.
pub fn run(data: &Path, out: &Path, tool: &Tool, asked: &Asked) -> Result<(Vec<RealOutcome>, Vec<String>), Error> {
    let (jobs, mut skipped) = jobs(data, asked);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(asked.workers).build();
    let pool = pool.map_err(|error| Error::Usage(format!("--workers: {error}")))?;
    let progress = Progress::new("diagnoses", jobs.len() as u64);
    let one = |&(number, held_out): &(usize, usize)| {
        let folder = out.join("real").join(number.to_string()).join(held_out.to_string());
        let made = fold(&MODELS[number], held_out, data, &folder, tool);
        progress.advance(1);
        made
    };
    let made: Vec<Result<Fold, Error>> = pool.install(|| jobs.par_iter().with_max_len(1).map(one).collect());
    let mut by_model: BTreeMap<usize, Vec<Fold>> = BTreeMap::new();
    for ((number, held_out), made) in jobs.into_iter().zip(made) {
        let model = &MODELS[number];
        match made {
            Ok(fold) => by_model.entry(number).or_default().push(fold),
            Err(error) => {
                skipped.push(format!("{}, {} held out: no answer: {error}", model.name(), model.recordings[held_out]));
            }
        }
    }
    let outcome = |(number, folds): (usize, Vec<Fold>)| {
        let model = &MODELS[number];
        let known =
            |(id, parameter, range, source): &Known| (format!("{id}.{parameter}"), *range, (*source).to_owned());
        let (name, hidden) = (model.name(), model.hidden.to_owned());
        RealOutcome { name, hidden, known: model.known.iter().map(known).collect(), folds }
    };
    Ok((by_model.into_iter().map(outcome).collect(), skipped))
}

/// Models and the recordings to hold out of each, and why others are left out.
fn jobs(data: &Path, asked: &Asked) -> (Vec<(usize, usize)>, Vec<String>) {
    let mut jobs = Vec::new();
    let mut skipped = Vec::new();
    for (number, model) in MODELS.iter().enumerate() {
        if !asked.sets.is_empty() && !asked.sets.iter().any(|set| set == model.folder) {
            continue;
        }
        if !data.join(model.folder).is_dir() {
            skipped.push(format!("{} skipped: {} is not there", model.name(), data.join(model.folder).display()));
            continue;
        }
        let folds = model.recordings.len().min(asked.folds.unwrap_or(usize::MAX));
        jobs.extend((0..folds).map(|fold| (number, fold)));
    }
    (jobs, skipped)
}

/// One diagnosis; of an earlier run where that is there.
fn fold(model: &Model, held_out: usize, data: &Path, out: &Path, tool: &Tool) -> Result<Fold, Error> {
    let file = out.join("outcome.json");
    if let Ok(earlier) = read_json(&file) {
        return Ok(earlier);
    }
    output::folder(out)?;
    let data = data.join(model.folder);
    let data = data.canonicalize().map_err(|error| Error::input(&data, None, "", error.to_string()))?;
    let mut machine = Machine::read(&data.join(model.file))?;
    (model.edit)(&mut machine);
    machine.write(&out.join("machine.toml"))?;
    let paths: Vec<String> = model.recordings.iter().map(|name| data.join(name).display().to_string()).collect();
    let fitted: Vec<&str> =
        paths.iter().enumerate().filter(|(index, _)| *index != held_out).map(|(_, path)| path.as_str()).collect();
    let question = Question {
        machine: "machine.toml",
        recordings: fitted.clone(),
        holdout: vec![&paths[held_out]],
        model: Some("improved.toml"),
        ..Question::default()
    };
    let started = std::time::Instant::now();
    let answer = tool.ask(out, "answer", &question)?;
    let seconds = started.elapsed().as_secs_f64();
    let written = Machine::read(&out.join("improved.toml"))?;
    let left = left(&machine, &written, &fitted, &paths[held_out])?;
    let fold = Fold {
        held_out: model.recordings[held_out].to_owned(),
        verdict: answer.verdict,
        named: answer.effects.iter().map(|effect| effect.id.clone()).collect(),
        answered: model.known.iter().map(|known| estimate(&answer, known)).collect(),
        left,
        without: Simulated::of(&written).without().clone(),
        seconds,
    };
    let text = serde_json::to_string_pretty(&fold).map_err(|error| Error::Usage(error.to_string()))?;
    output::write_text(&file, &text)?;
    Ok(fold)
}

/// What the nominal model, the written one and least squares leave on a recording that none was fitted on.
fn left(machine: &Machine, written: &Machine, fitted: &[&str], held_out: &str) -> Result<[[Option<f64>; 3]; 2], Error> {
    let read = |path: &str| Recording::of(Path::new(path), machine);
    let recordings: Vec<Recording> = fitted.iter().map(|path| read(path)).collect::<Result<_, _>>()?;
    let unseen = read(held_out)?;
    let baseline = least_squares::fitted(machine, &recordings.iter().collect::<Vec<_>>());
    Ok(HORIZONS_S.map(|horizon_s| {
        [Some(machine), Some(written), baseline.as_ref()]
            .map(|machine| machine.and_then(|machine| Simulated::of(machine).left(&unseen, horizon_s)))
    }))
}

/// The estimate of a known parameter; of several orders, the one that is meant.
fn estimate(answer: &Answer, &(id, parameter, [low, _], _): &Known) -> Option<[f64; 3]> {
    let effects = answer.effects.iter().filter(|effect| effect.id == id);
    let found = effects.flat_map(|effect| &effect.parameters).filter(|found| found.id == parameter);
    let values = found.filter_map(|found| Some([found.value?, found.low?, found.high?]));
    values.into_iter().find(|[value, ..]| parameter != "order_per_rev" || (value - low).abs() < SAME_ORDER)
}

/// The outcomes as one table: a row for each nominal model, its recordings held out in turn.
pub fn table(outcomes: &[RealOutcome]) -> Table {
    let head = vec![
        "machine and model",
        "hidden",
        "verdicts",
        "first names",
        "known value: found in, estimates",
        "50 ms left, over nominal: written, least squares",
        "200 ms",
    ];
    let row = |outcome: &RealOutcome| {
        let folds = &outcome.folds;
        vec![
            outcome.name.clone(),
            outcome.hidden.clone(),
            counted(folds.iter().map(|fold| fold.verdict.name().to_owned())),
            counted(folds.iter().map(|fold| fold.named.first().map_or_else(|| "-".to_owned(), Clone::clone))),
            values(outcome),
            shares(folds, 0),
            shares(folds, 1),
        ]
    };
    (head, outcomes.iter().map(row).collect())
}

/// Words with how often each came, most often first.
fn counted(words: impl Iterator<Item = String>) -> String {
    let mut times: BTreeMap<String, usize> = BTreeMap::new();
    words.for_each(|word| *times.entry(word).or_default() += 1);
    let mut times: Vec<(String, usize)> = times.into_iter().collect();
    times.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
    times.iter().map(|(word, times)| format!("{word} {times}")).collect::<Vec<_>>().join(", ")
}

fn values(outcome: &RealOutcome) -> String {
    let one = |(index, (what, [low, high], _)): (usize, &(String, [f64; 2], String))| {
        let found: Vec<f64> = outcome.folds.iter().filter_map(|fold| Some(fold.answered[index]?[0])).collect();
        let truth = if low == high { format!("{low}") } else { format!("{low} to {high}") };
        let ends = [f64::min, f64::max].map(|end| found.iter().copied().reduce(end));
        let estimates = match ends {
            [Some(least), Some(most)] if found.len() > 1 => format!(": {least:.4} to {most:.4}"),
            [Some(only), _] => format!(": {only:.4}"),
            _ => String::new(),
        };
        format!("{what} {truth}: {} of {}{estimates}", found.len(), outcome.folds.len())
    };
    let words: Vec<String> = outcome.known.iter().enumerate().map(one).collect();
    if words.is_empty() { "-".to_owned() } else { words.join("; ") }
}

/// Geometric means over the folds of what the written model and least squares leave, over what the nominal model leaves.
fn shares(folds: &[Fold], horizon: usize) -> String {
    let mean = |model: usize| {
        let ratios: Option<Vec<f64>> =
            folds.iter().map(|fold| Some((fold.left[horizon][model]? / fold.left[horizon][0]?).ln())).collect();
        ratios.map(|ratios| (ratios.iter().sum::<f64>() / ratios.len().max(1) as f64).exp())
    };
    let word = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}"));
    // What the written model has and the windows have not is said beside it.
    let without: BTreeSet<&str> = folds.iter().flat_map(|fold| &fold.without).map(String::as_str).collect();
    let without: Vec<&str> = without.into_iter().collect();
    let mark = if without.is_empty() { String::new() } else { format!(" (without {})", without.join(", ")) };
    format!("{}{mark}, {}", word(mean(1)), word(mean(2)))
}

#[cfg(test)]
mod tests;
