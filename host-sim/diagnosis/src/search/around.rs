//! What is scored and refitted around one hypothesis, each candidate once however often the search comes back to it.

use rayon::prelude::*;

use crate::effects::{Effect, VOCABULARY, Widening};
use crate::hypothesis::{Entry, Hypothesis, Refitted, refit, refit_linearised, refit_under};
use crate::likelihood::Noise;
use crate::problem::Problem;
use crate::score::{Candidate, by_chance, score};

use super::widening::likeliest;
use super::{Evidence, Rejected};

/// Effects that are refitted of all that are scored. The right one was among the first five in each of 66 tuning cases.
pub(super) const REFITTED: usize = 5;
/// Steps of a first refit, under the noise of the hypothesis that is extended: it ranks, for a noise of its own makes the better ones
/// better still.
const FIRST_STEPS: usize = 2;
/// Steps of one that goes to the optimum.
pub(super) const STEPS: usize = 10;

/// Among how many variants an effect was found, and how often chance has as much happen where it is an event.
#[derive(Debug, Clone, Copy)]
pub struct Odds {
    pub(super) tries: f64,
    pub(super) by_chance: f64,
    /// When it was taken.
    pub(super) taken: Evidence,
}

impl Odds {
    /// Of what was looked for in one place.
    pub fn of_one() -> Self {
        Self { tries: 1.0, by_chance: 0.0, taken: NOT_YET }
    }

    /// With how often chance has as much happen as the last entry of `to`, where that is an event.
    pub(super) fn beside_chance(self, problem: &Problem, from: &Hypothesis, to: &Refitted) -> Self {
        let event = to.hypothesis.entries.last().and_then(|last| (last.effect.span)(&last.values));
        Self { by_chance: event.map_or(0.0, |event| by_chance(problem, from, to, event)), ..self }
    }
}

/// Evidence of an entry that was put in without a test.
const NOT_YET: Evidence = (1.0, 0.0);

/// Number of free values.
fn freedom(refitted: &Refitted) -> f64 {
    refitted.hypothesis.entries.iter().map(|entry| entry.effect.freedom(&entry.values)).sum::<usize>() as f64
}

/// Log-likelihood with a price on each free value (Schwarz 1978).
pub(super) fn priced(problem: &Problem, refitted: &Refitted) -> f64 {
    refitted.log_likelihood - problem.price() * freedom(refitted)
}

/// A refit within its share of the work.
enum Trial {
    NotMade,
    /// No pass is finite.
    Impossible,
    /// As near to its optimum as the search asks.
    Ended(Refitted),
    /// As near as its share of the work took it, with the log-likelihood that the last of it brought.
    Begun(Refitted, f64),
}

impl Trial {
    fn refitted(&self) -> Option<&Refitted> {
        match self {
            Self::NotMade | Self::Impossible => None,
            Self::Ended(refitted) | Self::Begun(refitted, _) => Some(refitted),
        }
    }

    /// Begins, at the log-likelihood `from`, or goes on from where it came to.
    fn go_on(
        &mut self,
        problem: &Problem,
        share: u64,
        from: f64,
        begin: impl FnOnce(&Problem) -> Option<Refitted>,
        on: impl FnOnce(&Problem, &Refitted) -> Option<Refitted>,
    ) {
        let before = self.refitted().map_or(from, |refitted| refitted.log_likelihood);
        let (found, ended) = problem.sharing(share, |own| match self.refitted() {
            None => begin(own),
            Some(from) => on(own, from),
        });
        *self = match found {
            None => Self::Impossible,
            Some(refitted) if ended => Self::Ended(refitted),
            Some(refitted) => {
                let rise = (refitted.log_likelihood - before).max(0.0);
                Self::Begun(refitted, rise)
            }
        };
    }
}

/// A candidate with its refits.
struct Tried {
    candidate: Candidate,
    /// Whether it starts from the refit of an effect that its own widens.
    widened: bool,
    short: Trial,
    followed: Trial,
}

/// What one effect more makes of a hypothesis.
pub(super) struct Extended {
    pub(super) refitted: Refitted,
    pub(super) odds: Odds,
    /// Log-likelihood by which it may still be short of its optimum, for all that is known: where its share of the work did not end it, what
    /// the last of that brought, for steps of a refit bring less and less.
    pub(super) open: f64,
}

impl Extended {
    /// Whether it is known how it stands to a hypothesis of that log-likelihood: at its end, or farther behind than it may still rise.
    pub(super) fn is_decided(&self, best: f64) -> bool {
        is_decided(best - self.refitted.log_likelihood, self.open)
    }

    /// Joins others that are best first, in the place of one of the same effect that is less likely.
    pub(super) fn join(self, problem: &Problem, others: &mut Vec<Self>) {
        let effect = |one: &Self| one.refitted.hypothesis.entries.last().map(|last| last.effect);
        if let Some(same) = others.iter().position(|one| effect(one) == effect(&self)) {
            if others[same].refitted.log_likelihood >= self.refitted.log_likelihood {
                return;
            }
            others.remove(same);
        }
        let rank = priced(problem, &self.refitted);
        others.insert(others.partition_point(|one| priced(problem, &one.refitted) >= rank), self);
    }

    fn of(candidate: &Candidate, trial: &Trial) -> Option<Self> {
        let refitted = trial.refitted()?.clone();
        let odds = Odds { tries: candidate.tries, by_chance: 0.0, taken: NOT_YET };
        let open = if let Trial::Begun(_, rise) = trial { *rise } else { 0.0 };
        Some(Self { refitted, odds, open })
    }
}

fn is_decided(behind: f64, open: f64) -> bool {
    open == 0.0 || behind > open
}

/// A hypothesis with what is found around it.
pub(super) struct Around {
    at: Refitted,
    vocabulary: Vec<&'static Effect>,
    tried: Option<Vec<Tried>>,
}

impl Around {
    /// Of a hypothesis, for effects of that vocabulary. Nothing is computed before it is asked for.
    pub(super) fn new(at: &Refitted, vocabulary: &[&'static Effect]) -> Self {
        // Columns of all effects tell whether anything is left, whichever of them may be taken.
        let others = VOCABULARY.iter().copied().filter(|effect| !vocabulary.contains(effect));
        Self { at: at.clone(), vocabulary: vocabulary.iter().copied().chain(others).collect(), tried: None }
    }

    /// What is found around the same hypothesis under noise of another kind: what was followed goes on from its optimum.
    pub(super) fn under(self, at: &Refitted) -> Self {
        let anew = |Tried { candidate, widened, short, followed }: Tried| {
            let short = if followed.refitted().is_some() { followed } else { short };
            Tried { candidate, widened, short, followed: Trial::NotMade }
        };
        let tried = self.tried.map(|all| all.into_iter().map(anew).collect());
        Self { at: at.clone(), tried, ..self }
    }

    /// Candidates, best first.
    fn scored(&self, problem: &Problem) -> Vec<Tried> {
        let scored = score(problem, &self.at, &self.vocabulary).unwrap_or_default();
        scored.into_iter().map(|candidate| Tried::new(candidate, false)).collect()
    }

    /// The refits of the first few candidates among some effects, best first by likelihood with a price on each free value.
    pub(super) fn extended(&mut self, problem: &Problem, among: &[&'static Effect]) -> Vec<Extended> {
        let mut all = self.tried.take().unwrap_or_else(|| self.scored(problem));
        let mut found = Vec::new();
        if !problem.is_spent() {
            let price = problem.price();
            self.refitted_short(problem, &mut first_few(&mut all, among, price));
            let mut wider: Vec<Tried> = among.iter().filter_map(|effect| self.widened(problem, &all, effect)).collect();
            self.refitted_short(problem, &mut wider.iter_mut().collect::<Vec<_>>());
            all.extend(wider);
            let rank = |one: &Refitted| priced(problem, one);
            let mut ranked: Vec<(f64, &mut Tried)> = all
                .iter_mut()
                .filter(|tried| among.contains(&tried.candidate.entry.effect))
                .filter_map(|tried| Some((rank(tried.short.refitted()?), tried)))
                .collect();
            ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
            let mut first = first_of_its_effect();
            ranked.retain(|(_, tried)| first(tried));
            let mut followed: Vec<&mut Tried> =
                ranked.drain(..REFITTED.min(ranked.len())).map(|(_, tried)| tried).collect();
            self.follow(problem, &mut followed);
            found.extend(followed.iter().filter_map(|tried| self.as_followed(tried)));
            found.extend(ranked.iter().filter_map(|(_, tried)| Extended::of(&tried.candidate, &tried.short)));
            found.sort_by(|a: &Extended, b| rank(&b.refitted).total_cmp(&rank(&a.refitted)));
        }
        self.tried = Some(all);
        found
    }

    /// Effects with a column that promises too little to be refitted, each once, by what it promises.
    pub(super) fn unpromising(&self, problem: &Problem, among: &[&'static Effect]) -> Vec<Rejected> {
        let price = problem.price();
        let mut first = first_of_its_effect();
        let all = self.tried.iter().flatten().filter(|one| among.contains(&one.candidate.entry.effect));
        let too_little =
            all.filter(|one| first(one)).filter(|one| !one.candidate.entry.effect.remembers && !one.promises(price));
        let rejected = |one: &Tried| {
            let Candidate { entry, gain, .. } = &one.candidate;
            Rejected { effect: entry.effect, rise: *gain, gain: None, certain: false }
        };
        too_little.map(rejected).collect()
    }

    /// A start of an effect from the refit of the one that it widens, the likeliest on the excerpts; none where that one brings nothing,
    /// or where it has been made.
    fn widened(&self, problem: &Problem, all: &[Tried], effect: &'static Effect) -> Option<Tried> {
        let Widening { narrower, wider, .. } = effect.widens?;
        let of = |effect: &'static Effect| all.iter().filter(move |tried| tried.candidate.entry.effect == effect);
        if of(effect).any(|tried| tried.widened) {
            return None;
        }
        let refits = of(narrower).filter_map(|tried| tried.short.refitted());
        let from = refits.max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))?;
        if priced(problem, from) <= priced(problem, &self.at) {
            return None;
        }
        let starts = wider(&from.hypothesis.entries.last()?.values, &problem.excitation);
        let tries = of(effect).map(|tried| tried.candidate.tries).fold(0.0, f64::max) + starts.len() as f64;
        let values = likeliest(problem, &self.at.hypothesis, effect, starts, &from.noise)?;
        let gain = from.log_likelihood - self.at.log_likelihood;
        let entry = Entry { effect, values: values.clone() };
        Some(Tried::new(Candidate { entry, from: values, gain, tries }, true))
    }

    /// As far as ranks them.
    fn refitted_short(&self, problem: &Problem, starts: &mut [&mut Tried]) {
        let first_refit = |own: &Problem, from: &Refitted| self.shortly(own, &from.hypothesis);
        in_shares(
            problem,
            starts,
            |tried| &tried.short,
            |own, share, Tried { candidate, short, .. }| {
                short.go_on(own, share, self.at.log_likelihood, |own| self.short(own, candidate), first_refit);
            },
        );
    }

    fn short(&self, problem: &Problem, candidate: &Candidate) -> Option<Refitted> {
        let with = |values: &[f64]| self.at.hypothesis.with(candidate.entry.effect, values.to_vec());
        let refitted = |start: &Hypothesis| self.shortly(problem, start);
        let found = refitted(&with(&candidate.entry.values))?;
        // A step that leads astray is taken again from where it began, if a column had led it from there.
        let astray = found.log_likelihood <= self.at.log_likelihood && candidate.from != candidate.entry.values;
        if astray { refitted(&with(&candidate.from)) } else { Some(found) }
    }

    /// As far as ranks a hypothesis. What adds a memory may let a torque noise move the rotor that held still without it, so that
    /// under the noise of the other it is the worse the more that had to stand in for.
    fn shortly(&self, problem: &Problem, start: &Hypothesis) -> Option<Refitted> {
        let remembers = start.entries.last().is_some_and(|entry| entry.effect.remembers);
        let by = if remembers { refit_linearised } else { refit_under };
        by(problem, start, &self.at.noise, FIRST_STEPS)
    }

    /// What was followed; as far as ranked it, with all that brought still open, where the work was spent before it could be.
    fn as_followed(&self, tried: &Tried) -> Option<Extended> {
        let Trial::NotMade = tried.followed else { return Extended::of(&tried.candidate, &tried.followed) };
        let short = Extended::of(&tried.candidate, &tried.short)?;
        Some(Extended { open: short.refitted.log_likelihood - self.at.log_likelihood, ..short })
    }

    /// To the optimum.
    fn follow(&self, problem: &Problem, found: &mut [&mut Tried]) {
        let on = |own: &Problem, from: &Refitted, noise: &[Noise]| refit(own, &from.hypothesis, noise, STEPS);
        in_shares(
            problem,
            found,
            |tried| &tried.followed,
            |own, share, Tried { short, followed, .. }| {
                let from = short.refitted().map_or(f64::NEG_INFINITY, |refitted| refitted.log_likelihood);
                let begin = |own: &Problem| on(own, short.refitted()?, &self.at.noise);
                followed.go_on(own, share, from, begin, |own, from| on(own, from, &from.noise));
            },
        );
    }
}

/// Goes at a refit that needs more than its share: shares grow as others end, and with this many any that is left has had several
/// times what the others took.
const GOES: usize = 3;

/// Refits in parallel, each within its share of the work, so that they end alike in whatever order they are done. Those that did not
/// end go on within shares of what the others left.
fn in_shares(
    problem: &Problem,
    all: &mut [&mut Tried],
    trial: impl Fn(&Tried) -> &Trial + Sync,
    go_on: impl Fn(&Problem, u64, &mut Tried) + Sync,
) {
    let open = |tried: &Tried| matches!(trial(tried), Trial::NotMade | Trial::Begun(..));
    for _ in 0..GOES {
        let many = all.iter().filter(|tried| open(tried)).count();
        if many == 0 || problem.left() == 0 {
            break;
        }
        let allowed = share(problem, many);
        all.par_iter_mut().filter(|tried| open(tried)).for_each(|tried| go_on(problem, allowed, tried));
    }
}

/// Work that each of some refits may take: half of what is left in all, so that what comes after has the other half.
fn share(problem: &Problem, refits: usize) -> u64 {
    problem.left() / 2 / refits.max(1) as u64
}

/// Tells of each that comes whether it is the first of its effect.
fn first_of_its_effect() -> impl FnMut(&Tried) -> bool {
    let mut seen: Vec<&'static str> = Vec::new();
    move |one| {
        let id = one.candidate.entry.effect.id;
        let first = !seen.contains(&id);
        seen.push(id);
        first
    }
}

impl Tried {
    fn new(candidate: Candidate, widened: bool) -> Self {
        Self { candidate, widened, short: Trial::NotMade, followed: Trial::NotMade }
    }

    /// Whether the linear model, or the start itself, is worth the price of its free values: a refit that brings less is not taken.
    fn promises(&self, price: f64) -> bool {
        let Entry { effect, values } = &self.candidate.entry;
        self.candidate.gain > price * effect.freedom(values) as f64
    }
}

/// Of the first few candidates among some effects those that promise something, a second start of an effect where it has several valleys, and,
/// where any column says that something is left, of each effect with a memory, which has no column, the first.
fn first_few<'a>(tried: &'a mut [Tried], among: &[&'static Effect], price: f64) -> Vec<&'a mut Tried> {
    let something_left = tried.iter().any(|one| one.promises(price));
    let mut starts: Vec<&mut Tried> = Vec::new();
    let mut seen: Vec<&'static str> = Vec::new();
    let mut few = 0;
    for one in tried.iter_mut().filter(|one| among.contains(&one.candidate.entry.effect)) {
        let effect = one.candidate.entry.effect;
        let times = seen.iter().filter(|other| **other == effect.id).count();
        let one_of_few = few < 2 * REFITTED && times < 2 && (times == 0 || few < REFITTED);
        // What promises nothing keeps its place: the next ones promise less.
        few += usize::from(one_of_few);
        if (one_of_few && one.promises(price)) || (times == 0 && effect.remembers && something_left) {
            starts.push(one);
        }
        seen.push(effect.id);
    }
    starts
}

#[cfg(test)]
mod tests {
    use super::is_decided;

    #[test]
    fn a_refit_that_did_not_end_is_decided_where_it_cannot_come_as_far() {
        for (behind, open, decided) in [
            (-5.0, 0.0, true),
            (700.0, 0.0, true),
            (700.0, 20.0, true),
            (700.0, 900.0, false),
            (-5.0, 20.0, false),
            // A refit of which nothing is known.
            (700.0, f64::INFINITY, false),
            (f64::NAN, 20.0, false),
        ] {
            assert_eq!(is_decided(behind, open), decided, "{behind} {open}");
        }
    }
}
