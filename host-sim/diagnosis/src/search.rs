//! Forward selection with refits of the few, then backward elimination.

mod around;
mod neighbourhood;
mod widening;

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::confidence_set::{Assessed, Comparison, LEVEL_OF_THE_SET, Step};
use crate::effects::{Effect, NUISANCES};
use crate::hypothesis::{Entry, Hypothesis, Refitted, coloured_noise, noise_of, refit, with_likelier_neighbour};
use crate::likelihood::Noise;
use crate::problem::Problem;

pub use around::Odds;
use around::{Around, Extended};
use neighbourhood::Neighbourhood;

/// Most effects of one hypothesis: twice what the hardest case of the proof conceals.
const MOST_EFFECTS: usize = 6;

/// Significance of one step of the search, before it is corrected for all that was tried: one wrong step in a hundred.
pub const LEVEL_OF_A_STEP: f64 = 0.01;
/// Smallest improvement of the windows that is worth a name (diagnosis.md: at least 3 % less held-out error).
pub const SMALLEST_GAIN: f64 = 0.03;

/// Of an entry its p-value, corrected for all that was tried, and the gain of its windows.
pub type Evidence = (f64, f64);

/// What a search tried and found.
#[derive(Debug)]
pub struct Found {
    /// The nominal machine.
    pub nominal: Step,
    /// The best.
    pub best: Step,
    /// For each entry of the best whether all its rivals were looked at, and not what the budget of work left of them.
    pub looked_at: Vec<bool>,
    /// Of each entry of the best.
    pub evidence: Vec<Evidence>,
    /// Hypotheses beside the best.
    pub rivals: Vec<Rival>,
    /// What was refitted beside the best and not taken.
    pub rejected: Vec<Rejected>,
}

impl Found {
    /// Goes on with the best `without` an entry, which brought `gain`, and tells it among the rejected, with whether it is certain.
    pub(crate) fn take_out(&mut self, entry: usize, without: Step, gain: f64, certain: bool) {
        let best = &self.best.assessed.refitted;
        let rise = best.log_likelihood - without.assessed.refitted.log_likelihood;
        let effect = best.hypothesis.entries[entry].effect;
        let certain = certain && is_part_of_it(effect, gain);
        self.rejected.push(Rejected { effect, rise, gain: Some(gain), certain });
        self.best = without;
        self.forget(entry);
    }

    /// Which of these entries of the best brought the windows least; the first of several.
    pub(crate) fn weakest(&self, entries: impl Iterator<Item = usize>) -> Option<usize> {
        let gain = |entry: &usize| self.evidence.get(*entry).map_or(0.0, |(_, gain)| *gain);
        entries.min_by(|a, b| gain(a).total_cmp(&gain(b)))
    }

    /// Forgets what belongs to an entry that is in the best no longer.
    fn forget(&mut self, entry: usize) {
        if entry < self.evidence.len() {
            self.evidence.remove(entry);
        }
        if entry < self.looked_at.len() {
            self.looked_at.remove(entry);
        }
        self.rivals.retain(|rival| rival.place != entry);
        for rival in self.rivals.iter_mut().filter(|rival| rival.place > entry) {
            rival.place -= 1;
        }
    }
}

/// What was refitted in the place of an entry of the best.
#[derive(Debug)]
pub struct Rival {
    /// The entry's place.
    pub place: usize,
    /// At its optimum.
    pub step: Step,
    /// How much better the best is.
    pub behind: Comparison,
}

/// What was refitted beside the best and not taken.
#[derive(Debug, Clone)]
pub struct Rejected {
    /// The effect.
    pub effect: &'static Effect,
    /// Log-likelihood that it would add.
    pub rise: f64,
    /// Relative fall of the windows' root mean square that it would bring; none where the rise is not worth its free values.
    pub gain: Option<f64>,
    /// Whether chance and its free values do not explain that.
    pub certain: bool,
}

/// Noise to begin with.
pub fn first_noise(problem: &Problem) -> Vec<Noise> {
    let torque = problem.excitation.torque_rms.max(f64::MIN_POSITIVE.sqrt());
    // A tenth of the torque each sample: a search goes on from there.
    let density = (0.1 * torque).powi(2) * problem.excitation.period_s;
    let begin = Noise::white(problem.least_sensor_sd, density);
    let all = problem.recordings.len();
    noise_of(problem, &problem.nominal, &vec![begin; all], 4.0, 0..all)
}

/// The nominal machine.
pub fn nominal(problem: &Problem) -> Option<Refitted> {
    refit(problem, &Hypothesis::default(), &first_noise(problem), 1)
}

/// Probability that chance alone brings `gain` to an entry, corrected for all that was tried.
pub fn p_value(assessed: &Assessed, entry: usize, gain: f64, odds: Odds) -> f64 {
    let of = &assessed.refitted.hypothesis.entries[entry];
    let freedom = of.effect.freedom(&of.values).max(1);
    // Scatter over blocks tells nothing of what happens in one or two of them; how others of its kind stand out does.
    let once = (of.effect.span)(&of.values).is_some();
    let statistic = 2.0 * gain / if once { 1.0 } else { assessed.design_effect(entry) };
    let single = chance(statistic, freedom);
    (single * odds.tries * crate::effects::VOCABULARY.len() as f64).max(odds.by_chance).min(1.0)
}

/// Probability that chance alone brings twice the log-likelihood `statistic` to so many values (Wilks 1938).
pub(crate) fn chance(statistic: f64, freedom: usize) -> f64 {
    // Below the smallest normal number the distribution's argument would be rounded to 0, which it panics on.
    if statistic.is_nan() || statistic < f64::MIN_POSITIVE {
        return 1.0;
    }
    ChiSquared::new(freedom as f64).map_or(1.0, |chi| chi.sf(statistic))
}

/// The nominal machine with what others would stand in for where it is missing; none where it can have nothing of the kind, or beside a
/// fluid is no likelier with it.
fn first(problem: &Problem, nominal: &Step, vocabulary: &[&'static Effect]) -> Option<Step> {
    let entries: Vec<Entry> = vocabulary
        .iter()
        .filter(|effect| effect.first && problem.may_have(effect))
        .map(|effect| Entry { effect, values: vec![0.0; effect.parameters.len()] })
        .collect();
    if entries.is_empty() {
        return None;
    }
    let mut found = refit(problem, &Hypothesis { entries }, &nominal.assessed.refitted.noise, 10)?;
    in_plain_names(problem, vocabulary, &mut found.hypothesis);
    // Beside a fluid its search takes work that the other one needs, so only one that is likelier is gone on from. A measured torque always
    // has it: with a spring missing a skew was no likelier, and without the skew that spring was taken for an inertia.
    let is_worth_it = |first: &Step| problem.excitation.measured || priced(problem, first) > priced(problem, nominal);
    Step::new(problem, found).filter(is_worth_it)
}

/// Gives an entry that stands for others the name of what it is the same as by its values: a column beside a fluid that is stamped early
/// is a delay of the drive.
fn in_plain_names(problem: &Problem, vocabulary: &[&'static Effect], hypothesis: &mut Hypothesis) {
    for entry in hypothesis.entries.iter_mut().filter(|entry| entry.effect.first) {
        let same =
            |other: &&'static Effect| !other.first && problem.may_have(other) && entry.indistinct(problem, other);
        if let Some(other) = vocabulary.iter().copied().find(same) {
            entry.effect = other;
        }
    }
}

/// Searches within the work that is left, from the nominal machine and from the one with what others would stand in for; the likelier
/// end is gone on from.
pub fn search(problem: &Problem, vocabulary: &[&'static Effect]) -> Option<Found> {
    let nominal = Step::new(problem, nominal(problem)?)?;
    let all: Vec<&'static Effect> = vocabulary.iter().copied().chain(nuisances(vocabulary)).collect();
    let mut around_nominal = Around::new(&nominal.assessed.refitted, &all);
    let first = first(problem, &nominal, vocabulary);
    let allowed = problem.left() / 5 * if first.is_some() { 2 } else { 3 };
    let mut ends = vec![problem.within(allowed, |own| forward(own, vocabulary, nominal.clone(), &mut around_nominal))];
    if let Some(first) = first {
        let mut around_first = Around::new(&first.assessed.refitted, vocabulary);
        ends.push(problem.within(allowed, |own| forward(own, vocabulary, first, &mut around_first)));
    }
    let mut end = ends.into_iter().max_by(|a, b| priced(problem, &a.best).total_cmp(&priced(problem, &b.best)))?;
    in_plain_names(problem, vocabulary, &mut end.best.assessed.refitted.hypothesis);
    // A memory of the noise is looked for when nothing is missing that it would stand in for.
    let Some(coloured) = coloured(problem, &end.best) else {
        let around = &mut around_nominal;
        let looked = |own: &Problem| Neighbourhood::new(own, vocabulary, &nominal, around, end).found();
        return Some(problem.within(problem.left(), looked));
    };
    let noise = &coloured.assessed.refitted.noise;
    let nominal = Step::new(problem, refit(problem, &Hypothesis::default(), noise, COLOURED_STEPS)?)?;
    end.best = coloured;
    let mut around = around_nominal.under(&nominal.assessed.refitted);
    let looked = |own: &Problem| Neighbourhood::new(own, vocabulary, &nominal, &mut around, end).found();
    Some(problem.within(problem.left(), looked))
}

/// Steps of a refit under noise of another kind.
const COLOURED_STEPS: usize = 10;

/// The same hypothesis under noise that has a memory; none where that makes no recording likelier.
fn coloured(problem: &Problem, step: &Step) -> Option<Step> {
    let Refitted { hypothesis, noise, .. } = &step.assessed.refitted;
    let coloured = coloured_noise(problem, &hypothesis.physics(&problem.nominal), noise);
    if coloured == *noise {
        return None;
    }
    Step::new(problem, refit(problem, hypothesis, &coloured, COLOURED_STEPS)?)
}

/// Log-likelihood with a price on each free value.
fn priced(problem: &Problem, step: &Step) -> f64 {
    step.assessed.total() - problem.price() * step.assessed.freedom() as f64
}

/// The end of a forward selection.
struct Forward {
    best: Step,
    tried: Vec<Odds>,
    rejected: Vec<Rejected>,
}

/// From a hypothesis, and what is found around it.
fn forward(problem: &Problem, vocabulary: &[&'static Effect], from: Step, around: &mut Around) -> Forward {
    let mut best = from;
    let mut moved: Option<Around> = None;
    let began = best.assessed.refitted.hypothesis.entries.len();
    let mut tried = vec![Odds::of_one(); began];
    // What happens once is looked for when nothing that holds always is left.
    let lasting: Vec<&'static Effect> = vocabulary.iter().copied().filter(|effect| !effect.once).collect();
    let mut among: &[&'static Effect] = &lasting;
    let mut rejected = Vec::new();
    while best.assessed.refitted.hypothesis.entries.len() < MOST_EFFECTS + began && !problem.is_spent() {
        // Half of what is left, for the steps after it; the best of what that has begun is looked at whatever is left.
        let found = problem.within(problem.left() / 2, |own| around_best(&mut moved, around).extended(own, among));
        let mut begun = found.iter().enumerate().take_while(|(index, _)| *index == 0 || !problem.is_spent());
        match begun.find_map(|(_, one)| worth(problem, &best, &one.refitted, one.odds)) {
            Some((next, odds)) => {
                tried.push(odds);
                best = next;
                moved = Some(Around::new(&best.assessed.refitted, vocabulary));
            }
            None if among.len() < vocabulary.len() => among = vocabulary,
            None => {
                rejected = found.into_iter().filter_map(|one| not_taken(problem, &best, one)).collect();
                rejected.extend(around_best(&mut moved, around).unpromising(problem, among));
                break;
            }
        }
    }
    Forward { best: at_its_neighbours(problem, best), tried, rejected }
}

/// With the orders and rough numbers of its entries where the likelihood has its top, now that it has them all: an order had stood in for
/// some of what came later.
fn at_its_neighbours(problem: &Problem, step: Step) -> Step {
    let earlier = step.assessed.refitted.hypothesis.entries.len().saturating_sub(1);
    let mut likelier: Option<Refitted> = None;
    for entry in 0..earlier {
        let from = likelier.as_ref().unwrap_or(&step.assessed.refitted);
        let found = with_likelier_neighbour(problem, from, entry);
        likelier = found.filter(|found| found.hypothesis.explains(problem, entry)).or(likelier);
    }
    likelier.and_then(|found| Step::new(problem, found)).unwrap_or(step)
}

/// What was found around where a search has moved to, or around where it began.
fn around_best<'a>(moved: &'a mut Option<Around>, began: &'a mut Around) -> &'a mut Around {
    moved.as_mut().unwrap_or(began)
}

/// What a refit that was not taken would add, and whether that is certain.
fn not_taken(problem: &Problem, from: &Step, Extended { refitted: to, odds, .. }: Extended) -> Option<Rejected> {
    let effect = to.hypothesis.entries.last()?.effect;
    let rise = to.log_likelihood - from.assessed.refitted.log_likelihood;
    let worth_it = around::priced(problem, &to) > around::priced(problem, &from.assessed.refitted);
    let entry = to.hypothesis.entries.len() - 1;
    let next = if worth_it && !problem.is_spent() { Step::new(problem, to) } else { None };
    let gain = next.as_ref().map(|next| self::gain(problem, next, from, entry));
    let certain = next.zip(gain).is_some_and(|(next, gain)| {
        // Two passes more tell how often chance has an event: asked last.
        let odds = || odds.beside_chance(problem, &from.assessed.refitted.hypothesis, &next.assessed.refitted);
        is_part_of_it(effect, gain)
            && is_crossed(problem, &next, from, entry)
            && p_value(&next.assessed, entry, rise, odds()) < LEVEL_OF_A_STEP
    });
    Some(Rejected { effect, rise, gain, certain })
}

/// Whether an effect that brings this much less is part of what is missing: what changes samples and no motion is not, if that is less
/// than is relevant.
fn is_part_of_it(effect: &Effect, gain: f64) -> bool {
    !effect.changes_samples_only() || gain >= SMALLEST_GAIN
}

/// The step to a hypothesis with one entry more, if it is worth it.
fn worth(problem: &Problem, from: &Step, to: &Refitted, odds: Odds) -> Option<(Step, Odds)> {
    let rise = |to: &Refitted| to.log_likelihood - from.assessed.refitted.log_likelihood;
    if rise(to).is_nan() || rise(to) <= problem.price() {
        return None;
    }
    // Beside its order the blocks tell it differently, and so its spread.
    let entry = to.hypothesis.entries.len().checked_sub(1)?;
    let to = with_likelier_neighbour(problem, to, entry).unwrap_or_else(|| to.clone());
    if !to.hypothesis.explains(problem, entry) {
        return None;
    }
    let rise = rise(&to);
    let next = Step::new(problem, to)?;
    let odds = odds.beside_chance(problem, &from.assessed.refitted.hypothesis, &next.assessed.refitted);
    let p = p_value(&next.assessed, entry, rise, odds);
    let gain = gain(problem, &next, from, entry);
    let crossed = is_crossed(problem, &next, from, entry);
    let apart = next.assessed.away_from_neutral(problem, entry);
    (p < LEVEL_OF_A_STEP && gain >= SMALLEST_GAIN && crossed && apart)
        .then_some((next, Odds { taken: (p, gain), ..odds }))
}

/// Whether what chose no value is nearer with an entry than without it: all blocks together, and of what holds always the recordings that
/// judge by themselves, by their likelihood or by their windows; and if it moves windows, these.
pub(crate) fn is_crossed(problem: &Problem, with: &Step, without: &Step, entry: usize) -> bool {
    let of = &with.assessed.refitted.hypothesis.entries[entry];
    let once = (of.effect.span)(&of.values).is_some();
    let judged = || {
        with.assessed.judged(problem) > without.assessed.judged(problem)
            || with.windows.fall_from(&without.windows, problem) > 0.0
    };
    let not_refuted =
        || of.effect.changes_samples_only() || with.windows.p_of_being_right(&without.windows) >= LEVEL_OF_THE_SET;
    with.assessed.total() > without.assessed.total() && (once || judged() && not_refuted())
}

/// What an entry brings to the windows: those that judge, or those around an event. Where the motion is given the likelihood sees a band
/// of it only, so that what the windows beyond that lose is measured; a filter's likelihood tells whether an entry is right, and how
/// large it is what it moves.
pub(crate) fn gain(problem: &Problem, with: &Step, without: &Step, entry: usize) -> f64 {
    let entry = &with.assessed.refitted.hypothesis.entries[entry];
    if entry.effect.changes_samples_only() {
        // What changes samples and no motion shows in no window: the fall of the innovations' typical size instead.
        return fall(problem, with.assessed.refitted.log_likelihood - without.assessed.refitted.log_likelihood);
    }
    let span = (entry.effect.span)(&entry.values);
    let at_the_event = span.and_then(|(recording, from_s, to_s)| {
        let rows = problem.recordings.get(recording)?.rows_between(from_s, to_s);
        Some(with.windows.fall_at(&without.windows, recording, &rows))
    });
    at_the_event.unwrap_or_else(|| match problem.motions.is_empty() {
        true => with.windows.accounted(&without.windows, problem),
        false => with.windows.fall_from(&without.windows, problem),
    })
}

/// Relative fall of the innovations' typical size that a rise of the log-likelihood is.
pub(crate) fn fall(problem: &Problem, rise: f64) -> f64 {
    1.0 - (-rise / problem.residuals().max(1) as f64).exp()
}

/// What competes beside a vocabulary and may not be named: all but what is an effect of it under another name.
fn nuisances(vocabulary: &[&'static Effect]) -> impl Iterator<Item = &'static Effect> {
    let named: Vec<&'static str> = vocabulary.iter().map(|effect| effect.id).collect();
    NUISANCES.iter().copied().filter(move |one| !one.alike.iter().any(|id| named.contains(id)))
}
