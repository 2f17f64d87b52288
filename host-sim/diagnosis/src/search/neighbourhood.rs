//! Backward elimination: what is not missed goes, and what may stand in the place of each entry is looked at.

use crate::confidence_set::{Comparison, LEVEL_OF_THE_SET, Step, compare, excluded};
use crate::effects::Effect;
use crate::hypothesis::refit;
use crate::problem::Problem;

use super::around::{Around, Extended, Odds, REFITTED};
use super::widening::nested;
use super::{Evidence, Forward, Found, LEVEL_OF_A_STEP, MOST_EFFECTS, Rejected, Rival, SMALLEST_GAIN};
use super::{gain, is_crossed, is_part_of_it, nuisances, p_value, priced};

/// Swaps of an entry for another effect that are followed: each effect of the largest hypothesis once.
const MOST_SWAPS: usize = MOST_EFFECTS;

/// The best hypothesis with what was found around it so far.
pub(super) struct Neighbourhood<'a> {
    problem: &'a Problem,
    vocabulary: &'a [&'static Effect],
    nominal: &'a Step,
    around_nominal: &'a mut Around,
    best: Step,
    tried: Vec<Odds>,
    evidence: Vec<Evidence>,
    looked_at: Vec<bool>,
    rivals: Vec<Rival>,
    rejected: Vec<Rejected>,
    swaps: usize,
}

/// What a look at an entry came to.
enum Looked {
    /// It stays.
    Stays,
    /// The best is another one, and all its entries are to be looked at again.
    Moved,
}

impl<'a> Neighbourhood<'a> {
    /// Of the end of a forward selection.
    pub(super) fn new(
        problem: &'a Problem,
        vocabulary: &'a [&'static Effect],
        nominal: &'a Step,
        around_nominal: &'a mut Around,
        Forward { best, tried, rejected }: Forward,
    ) -> Self {
        let (evidence, looked_at, rivals) = (Vec::new(), Vec::new(), Vec::new());
        Self {
            problem,
            vocabulary,
            nominal,
            around_nominal,
            best,
            tried,
            evidence,
            looked_at,
            rivals,
            rejected,
            swaps: 0,
        }
    }

    /// Looks at every entry, and begins again where the best becomes another one.
    pub(super) fn found(mut self) -> Found {
        let mut at = 0;
        while at < self.entries() {
            if self.problem.is_spent() {
                // What was not looked at is told as found, without rivals.
                self.evidence.extend(self.tried[at..].iter().map(|odds| odds.taken));
                self.looked_at.resize(self.entries(), false);
                break;
            }
            at = match self.look_at(at) {
                Looked::Stays => at + 1,
                Looked::Moved => 0,
            };
        }
        let Self { nominal, best, evidence, looked_at, rivals, rejected, .. } = self;
        Found { nominal: nominal.clone(), best, looked_at, evidence, rivals, rejected }
    }

    fn entries(&self) -> usize {
        self.best.assessed.refitted.hypothesis.entries.len()
    }

    fn look_at(&mut self, at: usize) -> Looked {
        // What another entry stands on, as an asymmetry on its friction, cannot be dropped.
        let Some(without) = self.without(at) else {
            return self.stays(self.tried[at].taken, true);
        };
        let gain = gain(self.problem, &self.best, &without, at);
        let rise = self.best.assessed.refitted.log_likelihood - without.assessed.refitted.log_likelihood;
        let p = p_value(&self.best.assessed, at, rise, self.tried[at]);
        let certain = p <= LEVEL_OF_A_STEP
            && self.best.assessed.refitted.hypothesis.explains(self.problem, at)
            && is_crossed(self.problem, &self.best, &without, at)
            && self.best.assessed.away_from_neutral(self.problem, at);
        if !certain || gain < SMALLEST_GAIN {
            let effect = self.best.assessed.refitted.hypothesis.entries[at].effect;
            self.rejected.push(Rejected {
                effect,
                rise,
                gain: Some(gain),
                certain: certain && is_part_of_it(effect, gain),
            });
            return self.moved(at, without, None);
        }
        let (found, looked_at) = self.in_its_place(at, &without);
        let (found, taken): (Vec<Step>, Vec<Evidence>) = found.into_iter().unzip();
        let comparisons: Vec<Comparison> = found.iter().map(|rival| compare(self.problem, &self.best, rival)).collect();
        if let Some(other) = self.preferred(&found, &comparisons) {
            let odds = Odds { taken: taken[other], ..Odds::of_one() };
            return self.moved(at, found[other].clone(), Some(odds));
        }
        let rival = |(step, behind)| Rival { place: at, step, behind };
        self.rivals.extend(found.into_iter().zip(comparisons).map(rival));
        self.stays((p, gain), looked_at)
    }

    /// With the evidence of the next entry, and whether all that may stand in its place was looked at.
    fn stays(&mut self, evidence: Evidence, looked_at: bool) -> Looked {
        self.evidence.push(evidence);
        self.looked_at.push(looked_at);
        if !looked_at {
            self.problem.note_cut();
        }
        Looked::Stays
    }

    /// The best without an entry; none where nothing of the kind can be.
    fn without(&self, at: usize) -> Option<Step> {
        if self.entries() == 1 {
            return Some(self.nominal.clone());
        }
        self.best.without(self.problem, at)
    }

    /// Goes on from another hypothesis, whose entry in the place of the one at `at`, if there is one, stands last.
    fn moved(&mut self, at: usize, to: Step, new: Option<Odds>) -> Looked {
        self.tried.remove(at);
        self.tried.extend(new);
        self.best = to;
        self.evidence.clear();
        self.looked_at.clear();
        self.rivals.clear();
        Looked::Moved
    }

    /// Refits of what may stand in the place of an entry, each with its evidence, and whether that was looked at: whether any was
    /// refitted, or nothing is left to look for, and each came to its end or is farther behind than it may still rise. What does not
    /// explain what is missing there by itself is no rival, however little tells it apart.
    fn in_its_place(&mut self, at: usize, without: &Step) -> (Vec<(Step, Evidence)>, bool) {
        let problem = self.problem;
        let own = self.best.assessed.refitted.hypothesis.entries[at].effect;
        let others = self.vocabulary.iter().copied().filter(|effect| *effect != own);
        let others: Vec<&'static Effect> = others.chain(nuisances(self.vocabulary)).collect();
        let alone = self.entries() == 1;
        let mut found = match alone {
            true => self.around_nominal.extended(problem, &others),
            false => self.with_the_others_as_they_are(at, without, &others).extended(problem, &others),
        };
        found.truncate(REFITTED);
        for effect in others {
            if let Some(one) = nested(problem, &self.best.assessed.refitted, at, effect) {
                one.join(problem, &mut found);
            }
        }
        let best = self.best.assessed.refitted.log_likelihood;
        let looked_at = found.iter().all(|one| one.is_decided(best)) && !(found.is_empty() && problem.is_spent());
        let floor = without.assessed.refitted.log_likelihood;
        let rival = |Extended { refitted, odds, .. }: Extended| {
            let (rise, last) = (refitted.log_likelihood - floor, refitted.hypothesis.entries.len() - 1);
            if !refitted.hypothesis.explains(problem, last) {
                return None;
            }
            let rival = Step::new(problem, refitted)?;
            let gain = gain(problem, &rival, without, last);
            let relevant = gain >= SMALLEST_GAIN && is_crossed(problem, &rival, without, last);
            let odds = odds.beside_chance(problem, &without.assessed.refitted.hypothesis, &rival.assessed.refitted);
            let p = p_value(&rival.assessed, last, rise, odds);
            (relevant && p < LEVEL_OF_A_STEP).then_some((rival, (p, gain)))
        };
        (found.into_iter().filter_map(rival).collect(), looked_at)
    }

    /// The best without an entry, the others at their values in it: refitted alone they have taken over what they can of it, and
    /// from there no step may lead to a rival that shares it with them otherwise.
    fn with_the_others_as_they_are(&self, at: usize, without: &Step, vocabulary: &[&'static Effect]) -> Around {
        let hypothesis = self.best.assessed.refitted.hypothesis.without(at);
        let as_they_are = refit(self.problem, &hypothesis, &without.assessed.refitted.noise, 0);
        Around::new(as_they_are.as_ref().unwrap_or(&without.assessed.refitted), vocabulary)
    }

    /// The rival that is gone on from: a simpler one that these recordings do not tell from the best, else one that is certainly
    /// better.
    fn preferred(&mut self, found: &[Step], comparisons: &[Comparison]) -> Option<usize> {
        let freedom = self.best.assessed.freedom();
        let simpler = found
            .iter()
            .zip(excluded(comparisons))
            .position(|(rival, excluded)| !excluded && rival.may_be_named() && rival.assessed.freedom() < freedom);
        if simpler.is_some() || self.swaps == MOST_SWAPS {
            return simpler;
        }
        let (own, problem) = (priced(self.problem, &self.best), self.problem);
        let better = |rival: &Step| {
            let certainly = || compare(problem, rival, &self.best).p_value() < LEVEL_OF_THE_SET;
            let last = rival.assessed.refitted.hypothesis.entries.len() - 1;
            let apart = rival.assessed.away_from_neutral(problem, last);
            rival.may_be_named() && apart && priced(problem, rival) > own && certainly()
        };
        let better = found.iter().position(better);
        self.swaps += usize::from(better.is_some());
        better
    }
}
