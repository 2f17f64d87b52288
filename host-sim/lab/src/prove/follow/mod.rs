//! Checks that need no truth: recordings are changed in a way whose effect on the answer is known, and the answer must follow. What is
//! added to a real recording's commands must come back in its size.

mod changes;
mod log;

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::path::Path;

use conceal::case::{HELD_OUT, MACHINE};
use conceal::subject::Subject as Case;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub use self::changes::Change;
use self::changes::{Added, Subject};
use self::log::Log;
use super::answer::{Estimate, Named};
use super::run::Settings;
use super::text::Table;
use super::tool::{Question, read_json};
use super::{Answer, Verdict};
use crate::progress::Progress;
use crate::read::Machine;
use crate::{Error, output};

/// What is asked.
#[derive(Debug, Clone, Default)]
pub struct Asked {
    /// Simulated cases.
    pub seeds: Vec<u64>,
    /// Folders of real sets; all if empty.
    pub sets: Vec<String>,
    /// Changes; all if empty.
    pub changes: Vec<Change>,
}

/// A real subject: folder, machine file, recordings to fit, held out.
type Real = (&'static str, &'static str, &'static [&'static str], &'static str);

/// One model of each machine, the one with the most hidden; recordings of one kind of motion.
const REAL: [Real; 5] = [
    ("emps", "machine.toml", &["train.csv"], "pulses.csv"),
    ("odrive_cogging", "machine.toml", &["slow2_nocomp_0.csv", "slow2_nocomp_1.csv"], "slow2_nocomp_2.csv"),
    ("dfki", "heavy_no_gravity.toml", &["ddp.csv", "dircol.csv"], "ilqr.csv"),
    ("weigand", "j1_no_friction.toml", &["j1_A.csv", "j1_B.csv"], "j1_C.csv"),
    ("weigand", "j6_no_friction.toml", &["j6_A.csv", "j6_B.csv"], "j6_C.csv"),
];

/// Whether an answer followed one change.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Followed {
    /// Machine or seed.
    pub subject: String,
    /// Change.
    pub change: Change,
    /// Conclusion before and after.
    pub verdicts: [Verdict; 2],
    /// Names before and after.
    pub named: [Vec<String>; 2],
    /// Of the values that both have: how many agree within the 95 % intervals of both, and how many there are.
    pub values: [usize; 2],
    /// Of an added effect: its parameter, what it must be, and what came back with its interval.
    pub added: Option<(String, f64, Option<[f64; 3]>)>,
    /// The conclusion and all names are the same and all values agree; of an added effect, its size came back.
    pub follows: bool,
}

/// Changes every subject in every way; says of the others why there is no answer.
///
/// # Errors
/// Folders that cannot be made, threads that cannot be started.
pub fn run(data: &Path, settings: &Settings, asked: &Asked) -> Result<(Vec<Followed>, Vec<String>), Error> {
    let out = settings.out.join("follow");
    let mut skipped = Vec::new();
    let mut subjects = Vec::new();
    // Simulated cases alone, where sets are not asked for.
    for real in REAL.iter().filter(|real| asked.wants(real.0)) {
        match subject_of(&data.join(real.0), real.1, real.2, real.3) {
            Ok(subject) => subjects.push((format!("{}-{}", real.0, real.1.trim_end_matches(".toml")), subject)),
            Err(error) => skipped.push(format!("{} skipped: {error}", real.0)),
        }
    }
    for &seed in &asked.seeds {
        let folder = out.join("cases").join(seed.to_string());
        output::folder(&folder)?;
        let made = Case::draw(settings.plan, seed).and_then(|case| case.write(&folder).map(|()| case.fitted()));
        match made {
            Ok(fitted) => subjects.push((format!("seed-{seed}"), subject_of(&folder, MACHINE, fitted, HELD_OUT)?)),
            Err(error) => skipped.push(format!("seed {seed} skipped: {error}")),
        }
    }
    let changes = if asked.changes.is_empty() { Change::ALL.to_vec() } else { asked.changes.clone() };
    let progress = Progress::new("machines", subjects.len() as u64);
    let one = |(name, subject): &(String, Subject)| {
        let followed = all(name, subject, &changes, &out.join(name), settings);
        progress.advance(1);
        followed
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.workers).build();
    let pool = pool.map_err(|error| Error::Usage(format!("--workers: {error}")))?;
    let results: Vec<_> = pool.install(|| subjects.par_iter().with_max_len(1).map(one).collect());
    let mut outcomes = Vec::new();
    for (result, (name, _)) in results.into_iter().zip(&subjects) {
        match result {
            Ok(followed) => outcomes.extend(followed),
            Err(error) => skipped.push(format!("{name}: no answer: {error}")),
        }
    }
    Ok((outcomes, skipped))
}

impl Asked {
    fn wants(&self, set: &str) -> bool {
        if self.sets.is_empty() { self.seeds.is_empty() } else { self.sets.iter().any(|wanted| wanted == set) }
    }
}

fn subject_of(folder: &Path, machine: &str, fitted: &[&str], held_out: &str) -> Result<Subject, Error> {
    let log = |name: &&str| Log::read(&folder.join(name));
    Ok(Subject {
        machine: Machine { controller: None, ..Machine::read(&folder.join(machine))? },
        fitted: fitted.iter().map(log).collect::<Result<_, _>>()?,
        held_out: vec![log(&held_out)?],
    })
}

/// The answer as it is, then after each change.
fn all(
    name: &str,
    subject: &Subject,
    changes: &[Change],
    out: &Path,
    settings: &Settings,
) -> Result<Vec<Followed>, Error> {
    let before = ask(subject, &out.join("as-it-is"), settings)?;
    let mut followed = Vec::new();
    for &change in changes {
        let mut changed = subject.clone();
        let Some(added) = change.apply(&mut changed) else { continue };
        let after = ask(&changed, &out.join(change.name()), settings)?;
        followed.push(Followed::of(name, change, &before, &after, added.as_ref()));
    }
    Ok(followed)
}

/// Asks in a folder of its own; an answer of an earlier run stands.
fn ask(subject: &Subject, folder: &Path, settings: &Settings) -> Result<Answer, Error> {
    if let Ok(answer) = read_json(&folder.join("answer.json")) {
        return Ok(answer);
    }
    output::folder(folder)?;
    subject.machine.write(&folder.join(MACHINE))?;
    let mut names = [Vec::new(), Vec::new()];
    for (kind, logs) in [("fitted", &subject.fitted), ("held-out", &subject.held_out)] {
        for (index, log) in logs.iter().enumerate() {
            let name = format!("{kind}-{index}.csv");
            log.write(&folder.join(&name))?;
            names[usize::from(kind != "fitted")].push(name);
        }
    }
    let [fitted, held_out] = [0, 1].map(|k| names[k].iter().map(String::as_str).collect::<Vec<_>>());
    let question = Question { machine: MACHINE, recordings: fitted, holdout: held_out, ..Question::default() };
    settings.tool.ask(folder, "answer", &question)
}

impl Followed {
    fn of(name: &str, change: Change, before: &Answer, after: &Answer, added: Option<&Added>) -> Self {
        let names = |answer: &Answer| answer.effects.iter().map(|effect| effect.id.clone()).collect::<Vec<_>>();
        let named = [names(before), names(after)];
        let mut values = [0, 0];
        for effect in &before.effects {
            // Of several of one name, as orders of a cogging, the one that agrees most.
            let others = after.effects.iter().filter(|other| other.id == effect.id);
            let counts = others.map(|other| agreeing(change, effect, other));
            if let Some([agree, all]) = counts.max_by_key(|[agree, _]| *agree) {
                values = [values[0] + agree, values[1] + all];
            }
        }
        let added = added.map(|added| came_back(added, before, after));
        let same = |names: &[String]| names.iter().cloned().collect::<BTreeSet<_>>();
        let follows = match &added {
            Some((_, wanted, found)) => found.is_some_and(|[_, low, high]| low <= *wanted && *wanted <= high),
            None => before.verdict == after.verdict && same(&named[0]) == same(&named[1]) && values[0] == values[1],
        };
        let verdicts = [before.verdict, after.verdict];
        Self { subject: name.to_owned(), change, verdicts, named, values, added, follows }
    }
}

fn half(estimate: &Estimate) -> Option<f64> {
    Some(0.5 * (estimate.high? - estimate.low?))
}

/// Of the values that two effects have, how many agree and how many there are.
fn agreeing(change: Change, effect: &Named, other: &Named) -> [usize; 2] {
    let pairs = effect.parameters.iter().filter_map(|one| {
        let found = other.parameters.iter().find(|found| found.id == one.id)?;
        agrees(change, &effect.id, one, found)
    });
    pairs.fold([0, 0], |[agree, all], one| [agree + usize::from(one), all + 1])
}

/// Whether a value is what the change makes of it, within both intervals; none where there is no interval.
fn agrees(change: Change, id: &str, before: &Estimate, after: &Estimate) -> Option<bool> {
    let mut apart = after.value? - change.value(id, &before.id, before.value?);
    if before.id == "phase_rad" {
        apart -= (apart / TAU).round() * TAU;
    }
    let scale = change.value(id, &before.id, 1.0).abs();
    let allowed = half(after)?.hypot(scale * half(before)?);
    // Values without uncertainty, such as an order, are told to some digits.
    Some(apart.abs() <= allowed + 1e-6 * after.value?.abs())
}

/// What an added effect must be, by the answer before where that has it, else by the nominal model; and what it is.
fn came_back(added: &Added, before: &Answer, after: &Answer) -> (String, f64, Option<[f64; 3]>) {
    let find = |answer: &Answer| {
        let effect = answer.effects.iter().find(|effect| effect.id == added.id)?;
        effect.parameters.iter().find(|found| found.id == added.parameter).cloned()
    };
    let was = find(before);
    let from = was.as_ref().and_then(|was| was.value).unwrap_or(added.nominal);
    let spread = was.as_ref().and_then(half).unwrap_or(0.0);
    let found = find(after).filter(|_| after.verdict.offers()).and_then(|found| {
        let (value, half) = (found.value?, half(&found)?.hypot(spread));
        Some([value, value - half, value + half])
    });
    (format!("{}.{}", added.id, added.parameter), from + added.by, found)
}

/// The outcomes as a table.
pub fn table(outcomes: &[Followed]) -> Table {
    let head = vec!["subject", "change", "before", "after", "values that agree", "added: must be, is", ""];
    let words = |verdict: Verdict, named: &[String]| format!("{} {}", verdict.name(), named.join(" + "));
    let row = |one: &Followed| {
        let added = one.added.as_ref().map_or_else(String::new, |(what, wanted, found)| {
            let found = found.map_or_else(
                || "not found".to_owned(),
                |[value, low, high]| format!("{value:.4} [{low:.4}, {high:.4}]"),
            );
            format!("{what} {wanted:.4}, {found}")
        });
        vec![
            one.subject.clone(),
            one.change.name().to_owned(),
            words(one.verdicts[0], &one.named[0]),
            words(one.verdicts[1], &one.named[1]),
            format!("{}/{}", one.values[0], one.values[1]),
            added,
            if one.follows { "follows" } else { "DOES NOT FOLLOW" }.to_owned(),
        ]
    };
    (head, outcomes.iter().map(row).collect())
}

/// How many followed each change, one line each.
pub fn summary(outcomes: &[Followed]) -> String {
    let line = |change: Change| {
        let of: Vec<&Followed> = outcomes.iter().filter(|one| one.change == change).collect();
        let follow = of.iter().filter(|one| one.follows).count();
        (!of.is_empty()).then(|| format!("{}: {follow} of {} follow\n", change.name(), of.len()))
    };
    Change::ALL.into_iter().filter_map(line).collect()
}

#[cfg(test)]
mod tests;
