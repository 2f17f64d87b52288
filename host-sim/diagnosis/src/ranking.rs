//! A given list of hypotheses side by side, for questions that name their candidates themselves.

use rayon::prelude::*;

use crate::confidence_set::{Comparison, Step, compare, excluded};
use crate::hypothesis::{Hypothesis, Refitted, evaluate, refit};
use crate::problem::Problem;
use crate::search::nominal;

/// A hypothesis that competes.
#[derive(Debug, Clone)]
pub struct Contender {
    /// As the answer calls it.
    pub name: &'static str,
    /// Where its fit begins: the same effects at different values, one at least. A delay has several valleys.
    pub starts: Vec<Hypothesis>,
}

/// What became of a contender.
#[derive(Debug)]
pub struct Ranked {
    /// Its name.
    pub name: &'static str,
    /// At its optimum.
    pub step: Step,
    /// How much better the best is; none for the best itself.
    pub behind: Option<Comparison>,
    /// These recordings do not tell it from the best at [`crate::confidence_set::LEVEL_OF_THE_SET`].
    pub in_set: bool,
    /// It stands in the set, and nothing with fewer effects that it contains does: its values are all needed.
    pub needed: bool,
}

/// Starts of a contender that are followed to their optimum.
const FOLLOWED: usize = 2;
/// Most steps of a fit, as the search takes for those it follows.
const ROUNDS: usize = 10;

/// Fits every contender and compares it with the best, likeliest first; empty where no pass over the recordings is finite. `fitted_one`
/// is called whenever one is fitted, for whoever waits.
pub fn rank(problem: &Problem, contenders: &[Contender], fitted_one: impl Fn() + Sync) -> Vec<Ranked> {
    let Some(nominal) = nominal(problem) else { return Vec::new() };
    let finer = problem.finer();
    let fitted = |contender: &Contender| {
        let step = fit(problem, contender, &nominal).and_then(|step| step.estimated(&finer));
        fitted_one();
        Some((contender.name, step?))
    };
    let mut steps: Vec<(&'static str, Step)> = contenders.par_iter().filter_map(fitted).collect();
    steps.sort_by(|(_, a), (_, b)| b.assessed.total().total_cmp(&a.assessed.total()));
    let Some((_, best)) = steps.first() else { return Vec::new() };
    let behind: Vec<Comparison> = steps.iter().skip(1).map(|(_, step)| compare(problem, best, step)).collect();
    let excluded = excluded(&behind);
    let standing = behind.into_iter().map(Some).zip(excluded);
    let standings = std::iter::once((None, false)).chain(standing);
    let mut ranked: Vec<Ranked> = steps
        .into_iter()
        .zip(standings)
        .map(|((name, step), (behind, out))| Ranked { name, step, behind, in_set: !out, needed: !out })
        .collect();
    for at in 0..ranked.len() {
        let simpler = ranked.iter().any(|other| other.in_set && contains(&ranked[at], other));
        ranked[at].needed &= !simpler;
    }
    ranked
}

/// Whether one has every effect of another and more.
fn contains(one: &Ranked, other: &Ranked) -> bool {
    let effects = |of: &Ranked| -> Vec<&'static str> {
        of.step.assessed.refitted.hypothesis.entries.iter().map(|entry| entry.effect.id).collect()
    };
    let (one, other) = (effects(one), effects(other));
    one.len() > other.len() && other.iter().all(|id| one.contains(id))
}

fn fit(problem: &Problem, contender: &Contender, nominal: &Refitted) -> Option<Step> {
    let worth = |start: &Hypothesis| {
        let found = evaluate(problem, &start.physics(&problem.nominal), &nominal.noise, 0..problem.fitted);
        found.map_or(f64::NEG_INFINITY, |found| found.fitted(problem))
    };
    let mut starts: Vec<(f64, &Hypothesis)> = contender.starts.iter().map(|start| (worth(start), start)).collect();
    starts.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let followed = starts.iter().take(FOLLOWED).filter_map(|(_, start)| refit(problem, start, &nominal.noise, ROUNDS));
    Step::new(problem, followed.max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))?)
}
