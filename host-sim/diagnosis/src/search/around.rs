//! What is scored and refitted around one hypothesis, each candidate once however often the search comes back to it.

use std::sync::OnceLock;

use rayon::prelude::*;

use crate::effects::Effect;
use crate::hypothesis::{Hypothesis, Refitted, kept, refit};
use crate::problem::Problem;
use crate::score::{Candidate, score};

/// Effects that are refitted of all that are scored. The right one was among the first five in each of 66 tuning cases.
pub(super) const REFITTED: usize = 5;
/// Of these, how many are followed to their optimum.
const FOLLOWED: usize = 3;
/// Steps of a first refit, that ranks, and of one that goes to the optimum.
const STEPS: [usize; 2] = [2, 10];

/// Among how many variants an effect was found, and how often chance has its start stand out.
#[derive(Debug, Clone, Copy)]
pub struct Odds {
    pub(super) tries: f64,
    pub(super) by_chance: f64,
    /// p-value and gain when it was taken.
    pub(super) taken: (f64, f64),
}

/// Evidence of an entry that was put in without a test.
pub(super) const NOT_YET: (f64, f64) = (1.0, 0.0);

/// Number of free values.
pub(super) fn freedom(refitted: &Refitted) -> f64 {
    refitted.hypothesis.entries.iter().map(|entry| entry.effect.freedom(&entry.values)).sum::<usize>() as f64
}

/// A candidate with its refits, none where no pass is finite.
struct Tried {
    candidate: Candidate,
    short: OnceLock<Option<Refitted>>,
    followed: OnceLock<Option<Refitted>>,
}

/// A hypothesis with what is found around it.
pub(super) struct Around {
    at: Refitted,
    vocabulary: Vec<&'static Effect>,
    tried: OnceLock<Vec<Tried>>,
}

impl Around {
    /// Of a hypothesis, for effects of that vocabulary. Nothing is computed before it is asked for.
    pub(super) fn new(at: &Refitted, vocabulary: &[&'static Effect]) -> Self {
        Self { at: at.clone(), vocabulary: vocabulary.to_vec(), tried: OnceLock::new() }
    }

    /// Candidates, best first.
    fn tried(&self, problem: &Problem) -> &[Tried] {
        self.tried.get_or_init(|| {
            let physics = self.at.hypothesis.physics(&problem.nominal);
            let path = kept(problem, &physics, &self.at.noise, problem.fitted);
            let scored =
                path.map(|path| score(problem, &self.at.hypothesis, &path, &self.vocabulary)).unwrap_or_default();
            let tried = |candidate| Tried { candidate, short: OnceLock::new(), followed: OnceLock::new() };
            scored.into_iter().map(tried).collect()
        })
    }

    /// The refits of the first few candidates among some effects, best first by likelihood with a price on each free value.
    pub(super) fn extended(&self, problem: &Problem, among: &[&'static Effect]) -> Vec<(Refitted, Odds)> {
        let starts = first_few(self.tried(problem), among);
        if problem.is_spent() {
            return Vec::new();
        }
        let price = problem.price();
        let rank = |found: &mut Vec<(&Tried, &Refitted)>| {
            let worth = |one: &Refitted| one.log_likelihood - price * freedom(one);
            found.sort_by(|a, b| worth(b.1).total_cmp(&worth(a.1)));
        };
        // In parallel to compute, in order to collect.
        let allowed = share(problem, starts.len());
        starts.par_iter().for_each(|tried| {
            tried.short.get_or_init(|| problem.within(allowed, |own| self.short(own, &tried.candidate)));
        });
        let mut found: Vec<(&Tried, &Refitted)> =
            starts.iter().filter_map(|tried| Some((*tried, tried.short.get()?.as_ref()?))).collect();
        rank(&mut found);
        let mut once: Vec<&'static str> = Vec::new();
        found.retain(|(tried, _)| {
            let id = tried.candidate.entry.effect.id;
            let first = !once.contains(&id);
            once.push(id);
            first
        });
        let rest = found.split_off(FOLLOWED.min(found.len()));
        let allowed = share(problem, found.len());
        let follow = |&(tried, start): &(&Tried, &Refitted)| {
            let followed = |own: &Problem| refit(own, &start.hypothesis, &start.noise, STEPS[1]);
            tried.followed.get_or_init(|| problem.within(allowed, followed));
        };
        found.par_iter().for_each(follow);
        let mut found: Vec<(&Tried, &Refitted)> =
            found.into_iter().filter_map(|(tried, _)| Some((tried, tried.followed.get()?.as_ref()?))).collect();
        found.extend(rest);
        rank(&mut found);
        found.into_iter().map(|(tried, refitted)| (refitted.clone(), odds(&tried.candidate))).collect()
    }

    fn short(&self, problem: &Problem, candidate: &Candidate) -> Option<Refitted> {
        let with = |values: &[f64]| self.at.hypothesis.with(candidate.entry.effect, values.to_vec());
        let refitted = |start: &Hypothesis| refit(problem, start, &self.at.noise, STEPS[0]);
        let found = refitted(&with(&candidate.entry.values))?;
        // A step that leads astray is taken again from where it began.
        if found.log_likelihood > self.at.log_likelihood { Some(found) } else { refitted(&with(&candidate.from)) }
    }
}

/// Work that each of some refits may take: half of what is left in all, so that what comes after has the other half.
fn share(problem: &Problem, refits: usize) -> u64 {
    problem.left() / 2 / refits.max(1) as u64
}

fn odds(candidate: &Candidate) -> Odds {
    Odds { tries: candidate.tries, by_chance: candidate.by_chance, taken: NOT_YET }
}

/// The first few candidates among some effects, a second start of an effect where it has several valleys, and of each effect with a
/// memory, whose column says little, the first.
fn first_few<'a>(tried: &'a [Tried], among: &[&'static Effect]) -> Vec<&'a Tried> {
    let mut starts: Vec<&Tried> = Vec::new();
    let mut seen: Vec<&'static str> = Vec::new();
    let mut few = 0;
    for one in tried.iter().filter(|one| among.contains(&one.candidate.entry.effect)) {
        let effect = one.candidate.entry.effect;
        let times = seen.iter().filter(|other| **other == effect.id).count();
        let among_the_few = few < 2 * REFITTED && times < 2 && (times == 0 || few < REFITTED);
        if among_the_few || (times == 0 && effect.remembers) {
            starts.push(one);
            few += usize::from(among_the_few);
        }
        seen.push(effect.id);
    }
    starts
}
