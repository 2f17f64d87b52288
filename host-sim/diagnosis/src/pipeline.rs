//! From recordings to the conclusion; the only place that knows every stage.

use crate::confidence_set::{Comparison, Interval, Step, alike_in_part, excluded, intervals};
use crate::effects::{Effect, VOCABULARY};
use crate::hypothesis::{Entry, Hypothesis, refit};
use crate::physics::Physics;
use crate::problem::Problem;
use crate::remainder::{Remainder, remainder};
use crate::search::{
    Found, LEVEL_OF_A_STEP, Odds, Rejected, SMALLEST_GAIN, chance, first_noise, gain, p_value, search,
};
use crate::verdict::{Standing, Verdict, verdict};
use crate::work::WORK;

/// One effect of the answer.
#[derive(Debug, Clone)]
pub struct Named {
    /// The effect.
    pub effect: &'static Effect,
    /// Fitted values.
    pub entry: Entry,
    /// Reported values, in the order of the effect's parameters in the vocabulary.
    pub intervals: Vec<Interval>,
    /// What the recordings cannot tell from it, best first.
    pub equivalent: Vec<&'static Effect>,
    /// What is no effect of the vocabulary and predicts as much with as few free values.
    pub nuisances: Vec<&'static Effect>,
    /// Whether one of those is as simple.
    pub standing: Standing,
    /// Probability that chance brings as much, corrected for all that was tried.
    pub p_value: f64,
    /// Relative fall of the windows' root mean square.
    pub gain: f64,
    /// Index of the recording it happens in, for events.
    pub recording: Option<usize>,
}

/// The conclusion with everything it was drawn from.
#[derive(Debug)]
pub struct Conclusion {
    /// The verdict.
    pub verdict: Verdict,
    /// Effects of the best hypothesis, by evidence.
    pub effects: Vec<Named>,
    /// What is left, where something predictable is.
    pub remainder: Option<Remainder>,
    /// The nominal machine.
    pub nominal: Step,
    /// The best hypothesis.
    pub best: Step,
    /// The best hypothesis, then those beside it that these recordings do not exclude though another motion may, by their
    /// log-likelihood.
    pub in_the_set: Vec<Hypothesis>,
    /// Whether the search ended at its budget of work.
    pub cut_short: bool,
    /// What was refitted and not taken, with the log-likelihood it would have brought.
    pub rejected: Vec<Rejected>,
}

impl Conclusion {
    /// The machine with the effects of the best hypothesis.
    pub fn physics(&self, problem: &Problem) -> Physics {
        self.best.assessed.refitted.hypothesis.physics(&problem.nominal)
    }

    /// Effects with a value that is the last that is looked at.
    pub fn at_an_end(&self, problem: &Problem) -> impl Iterator<Item = &Named> {
        self.effects.iter().filter(|one| one.entry.is_at_an_end(problem))
    }
}

/// Correlation of two effects' values beyond which they only say what their difference is: a variance inflation factor of 50
/// (ten is the usual warning, Belsley, Kuh and Welsch 1980).
const MOST_COLLINEAR: f64 = 0.99;
/// Most equivalents that are listed (diagnosis.md).
const MOST_EQUIVALENTS: usize = 3;

/// What no motion tells from it, then what these recordings do not tell from it or from a part of it.
fn equivalent(problem: &Problem, entry: &Entry, alike: impl Iterator<Item = &'static Effect>) -> Vec<&'static Effect> {
    let always = VOCABULARY.iter().copied().filter(|other| entry.indistinct(problem, other));
    let mut all: Vec<&'static Effect> = always.collect();
    for other in alike {
        if !all.contains(&other) {
            all.push(other);
        }
    }
    all.truncate(MOST_EQUIVALENTS);
    all
}

/// Work that a torque of samples may take as the cause of the motion, in substeps of three states: half as much again as three recordings of
/// 8 s at 2 kHz take. A measured torque that has much that moves nothing takes all of it.
const WORK_ON_SAMPLES: u64 = 100_000_000;

/// Diagnoses, and returns the problem as its torque column was read: where it may be a measurement, also as the cause of the motion.
/// That reading shows what is faster than the other's band, but takes its noise for that of the motion up to the sampling
/// rate: it is believed if it predicts what judges by a relevant part better, or as well and explains everything, with fewer values
/// than the other or where the other found nothing. Samples have noise that moves nothing, which pulls gains towards less motion, and they are
/// believed only where nothing predictable is left: on real machines a gravity of 2.99 N m came with a gain of 0.68, and predicted better. Nor
/// are held commands of which something is left with a value at the end of what is looked at: a lift that held itself came with a limit of 0.2 N m
/// or with four times the inertia in the place of its weight, which predict well that nothing moves.
/// None where no pass over the recordings is finite.
pub fn diagnose_as_read(problem: Problem, vocabulary: &[&'static Effect]) -> Option<(Problem, Conclusion)> {
    let measured = diagnose(&problem, vocabulary)?;
    let (problem, measured) = match read_again(&problem, &measured, vocabulary) {
        Some(again) => again,
        None => (problem, measured),
    };
    let Some(commands) = problem.as_commands() else { return Some((problem, measured)) };
    let held = commands.is_held();
    // What is predictable up to that band is so for a reading that sees more.
    if !held && measured.remainder.is_some() {
        return Some((problem, measured));
    }
    let left = WORK.saturating_sub(problem.work());
    let commands = commands.allowing(if held { left } else { left.min(WORK_ON_SAMPLES) });
    let believed = diagnose(&commands, vocabulary).filter(|commanded| {
        let freedom = |found: &Conclusion| found.best.assessed.freedom();
        let simpler = measured.effects.is_empty() || freedom(commanded) < freedom(&measured);
        let explains = commanded.remainder.is_none();
        let may_leave = held
            && commanded.at_an_end(&commands).next().is_none()
            && !moves_less(&commanded.physics(&commands), &measured.physics(&problem));
        if !explains && !may_leave {
            return false;
        }
        match prediction(&commands, &commanded.best, &measured.best) {
            Prediction::Better => true,
            Prediction::Alike => !commanded.cut_short && explains && simpler,
            Prediction::Worse => false,
        }
    });
    Some(match believed {
        Some(commanded) => (commands, commanded),
        None => (problem, measured),
    })
}

/// Whether the same torque accelerates one machine less than the other, by what is relevant.
fn moves_less(own: &Physics, other: &Physics) -> bool {
    let per_torque = |physics: &Physics| physics.model.torque_gain / physics.model.inertia;
    per_torque(own) < (1.0 - SMALLEST_GAIN) * per_torque(other)
}

/// The problem with the rows of the torque column read the other way, as samples or as values held to the next row, and what is found so;
/// none where that is not asked for or less likely. Half a row between the readings is a skew of the channels, and which reading is right was
/// decided on the nominal machine, which may lack too much to tell: so the other one is tried where what was found is likelier with it (and no
/// command between two rows is lost, of which neither is right), or has a skew or a delay that is nearer to its half row than to none.
fn read_again(problem: &Problem, found: &Conclusion, vocabulary: &[&'static Effect]) -> Option<(Problem, Conclusion)> {
    let other = problem.read_otherwise()?;
    let is_asked = is_nearer(&other, problem, found) || (!problem.loses_commands && is_likelier(&other, found));
    if !is_asked {
        return None;
    }
    let other = other.allowing(WORK.saturating_sub(problem.work()));
    let again = diagnose(&other, vocabulary)?;
    explains_as_well(problem, &again, found).then_some((other, again))
}

/// Whether what one reading found is taken in the place of what the other did: where it needs fewer values, unless those more are certain as
/// a step of the search has to be, and else where it is likelier for its values (Schwarz 1978).
fn explains_as_well(problem: &Problem, again: &Conclusion, found: &Conclusion) -> bool {
    let (again, found) = (&again.best.assessed, &found.best.assessed);
    let rise = found.refitted.log_likelihood - again.refitted.log_likelihood;
    let more = found.freedom() as f64 - again.freedom() as f64;
    if more > 0.0 {
        chance(2.0 * rise, found.freedom() - again.freedom()) * VOCABULARY.len() as f64 >= LEVEL_OF_A_STEP
    } else {
        rise < problem.price() * more
    }
}

/// Whether the same effects are likelier with the other reading, by more than one value more would have to bring: half a row less of a skew
/// that was found brings nothing.
fn is_likelier(other: &Problem, found: &Conclusion) -> bool {
    let own = &found.best.assessed.refitted;
    let refitted = refit(other, &own.hypothesis, &own.noise, STEPS_OF_THE_OTHER);
    refitted.is_some_and(|refitted| refitted.log_likelihood > own.log_likelihood + other.price())
}

/// Whether the skew or the delay that was found is, in every recording, nearer to the other reading's half row than to none.
fn is_nearer(other: &Problem, problem: &Problem, found: &Conclusion) -> bool {
    let later_s = |physics: &Physics| physics.skew_s + physics.model.sensor.latency_s + physics.model.torque_delay_s;
    let found_s = later_s(&found.physics(problem)) - later_s(&problem.nominal);
    (0..problem.fitted).all(|index| {
        let apart_s = problem.early_s[index] - other.early_s[index];
        (found_s - apart_s).abs() < 0.5 * apart_s.abs()
    })
}

/// Refits of the other reading's values: they are at an optimum already, but not at this one's.
const STEPS_OF_THE_OTHER: usize = 2;

/// How a hypothesis predicts the windows that judge, beside another.
enum Prediction {
    /// By a relevant part better at one horizon, and at none worse.
    Better,
    Alike,
    Worse,
}

/// How a hypothesis predicts commands' windows beside one of the other reading: better than one that cannot be followed.
fn prediction(commands: &Problem, own: &Step, other: &Step) -> Prediction {
    let hypothesis = &other.assessed.refitted.hypothesis;
    let refitted = refit(commands, hypothesis, &first_noise(commands), STEPS_OF_THE_OTHER);
    let Some(other) = refitted.and_then(|refitted| Step::new(commands, refitted)) else { return Prediction::Better };
    let better = own.windows.fall_from(&other.windows, commands) >= SMALLEST_GAIN;
    let worse = other.windows.fall_from(&own.windows, commands) >= SMALLEST_GAIN;
    match (better, worse) {
        (_, true) => Prediction::Worse,
        (true, false) => Prediction::Better,
        (false, false) => Prediction::Alike,
    }
}

/// Share of the work that is kept for the estimate of the values, one in this many ...
const OF_ESTIMATE: u64 = 3;
/// ... whose passes are about so many, of three states: 250 for the nominal machine and one of five values beside it.
const PASSES_OF_ESTIMATE: u64 = 250;

/// Diagnoses a problem as it is read, within [`WORK`] or what the problem allows where that is less; none where no pass over the
/// recordings is finite.
pub fn diagnose(problem: &Problem, vocabulary: &[&'static Effect]) -> Option<Conclusion> {
    problem.within(problem.left().min(WORK), |own| concluded(own, vocabulary))
}

fn concluded(problem: &Problem, vocabulary: &[&'static Effect]) -> Option<Conclusion> {
    let of_estimate = problem.left() / OF_ESTIMATE;
    problem.tally().estimating(false);
    let found = problem.within(problem.left() - of_estimate, |own| search(own, vocabulary))?;
    problem.tally().estimating(true);
    // A motion that is given is not integrated.
    let integrated = problem.motions.is_empty() && !found.best.assessed.refitted.hypothesis.entries.is_empty();
    let finer = integrated.then(|| problem.finer_within(of_estimate, PASSES_OF_ESTIMATE));
    let found = match &finer {
        Some(finer) => estimated(finer, found),
        None => without_doubtful(problem, Found { best: found.best.clone().widened(problem), ..found }),
    };
    let left = remainder(finer.as_ref().unwrap_or(problem), &found);
    let (effects, in_the_set) = named(problem, &found, vocabulary);
    if let Some(finer) = finer {
        problem.work.add(&finer.work);
    }
    let standings: Vec<Standing> = effects.iter().map(|effect| effect.standing).collect();
    let verdict = verdict(&standings, left.is_some());
    let rejected = found.rejected;
    Some(Conclusion {
        verdict,
        effects,
        remainder: left,
        nominal: found.nominal,
        best: found.best,
        in_the_set,
        cut_short: problem.was_cut(),
        rejected,
    })
}

/// With the values on a finer grid.
fn estimated(finer: &Problem, found: Found) -> Found {
    match (found.nominal.estimated(finer), found.best.estimated(finer)) {
        (Some(nominal), Some(best)) => without_weak(finer, without_doubtful(finer, Found { nominal, best, ..found })),
        _ => found,
    }
}

/// Without the entries that the substeps of the search only seemed to need: the weakest first is tested again as the search tests it.
fn without_weak(finer: &Problem, mut found: Found) -> Found {
    while !finer.is_spent() {
        let Some(at) = found.weakest(0..found.evidence.len()) else { break };
        let Some(without) = found.best.without(finer, at) else { break };
        let best = &found.best.assessed;
        let rise = best.refitted.log_likelihood - without.assessed.refitted.log_likelihood;
        let gain = gain(finer, &found.best, &without, at);
        let certain = p_value(best, at, rise, Odds::of_one()) < LEVEL_OF_A_STEP;
        if certain && gain >= SMALLEST_GAIN {
            break;
        }
        found.take_out(at, without.widened(finer), gain, certain);
    }
    found
}

/// Without the entries whose intervals hold what they are without the effect, the weakest first: what it stood beside may then be sure.
fn without_doubtful(finer: &Problem, mut found: Found) -> Found {
    loop {
        let best = &found.best.assessed;
        let doubtful = |at: &usize| !best.away_from_neutral(finer, *at);
        let Some(at) = found.weakest((0..best.refitted.hypothesis.entries.len()).filter(doubtful)) else {
            return found;
        };
        if finer.is_spent() {
            return found;
        }
        let Some(without) = found.best.without(finer, at) else { return found };
        let gain = gain(finer, &found.best, &without, at);
        found.take_out(at, without.widened(finer), gain, false);
    }
}

/// What the recordings do not tell from one entry of the best.
#[derive(Default)]
struct Beside<'a> {
    /// Hypotheses that an effect of the vocabulary makes in its place, with the log-likelihood by which each is worse.
    alike: Vec<(f64, &'a Hypothesis, usize, &'static Effect)>,
    /// What is no effect.
    nuisances: Vec<&'static Effect>,
}

fn beside<'a>(found: &'a Found, excluded: &[bool], at: usize) -> Beside<'a> {
    let own = found.best.assessed.freedom();
    let mut beside = Beside::default();
    for (rival, excluded) in found.rivals.iter().zip(excluded).filter(|(rival, _)| rival.place == at) {
        let hypothesis = &rival.step.assessed.refitted.hypothesis;
        let freedom = rival.step.assessed.freedom();
        let Some(other) = hypothesis.entries.last().map(|entry| entry.effect) else { continue };
        if !other.nameable {
            if !excluded && freedom <= own {
                beside.nuisances.push(other);
            }
        } else if !excluded && !beside.alike.iter().any(|(.., effect)| *effect == other) {
            beside.alike.push((rival.behind.difference, hypothesis, freedom, other));
        }
    }
    beside.alike.sort_by(|a, b| a.0.total_cmp(&b.0));
    beside
}

fn named(problem: &Problem, found: &Found, vocabulary: &[&'static Effect]) -> (Vec<Named>, Vec<Hypothesis>) {
    let best = &found.best.assessed;
    let mut in_the_set: Vec<(f64, Hypothesis)> = Vec::new();
    let comparisons: Vec<Comparison> = found.rivals.iter().map(|rival| rival.behind).collect();
    let excluded = excluded(&comparisons);
    let in_part = alike_in_part(problem, best, vocabulary);
    let mut effects: Vec<Named> = Vec::new();
    for (at, entry) in best.refitted.hypothesis.entries.iter().enumerate() {
        let Beside { alike, nuisances } = beside(found, &excluded, at);
        let told = |other: &Effect| !entry.indistinct(problem, other);
        let others = alike.iter().filter(|(.., other)| told(other));
        in_the_set.extend(others.clone().map(|(difference, hypothesis, ..)| (*difference, (*hypothesis).clone())));
        let standing = match others.map(|(_, _, freedom, _)| *freedom).min() {
            _ if found.looked_at.get(at) != Some(&true) => Standing::NotCompared,
            _ if !nuisances.is_empty() || best.collinear(at) > MOST_COLLINEAR => Standing::Contested,
            None => Standing::Certain,
            Some(fewest) if fewest > best.freedom() => Standing::CertainBySimplicity,
            Some(_) => Standing::Contested,
        };
        let (p_value, gain) = found.evidence.get(at).copied().unwrap_or((1.0, 0.0));
        effects.push(Named {
            effect: entry.effect,
            entry: entry.clone(),
            intervals: intervals(best, at),
            equivalent: equivalent(
                problem,
                entry,
                alike.iter().map(|(.., other)| *other).chain(in_part[at].iter().copied()),
            ),
            nuisances,
            standing,
            p_value,
            gain,
            recording: (entry.effect.span)(&entry.values).map(|(recording, ..)| recording),
        });
    }
    effects.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    in_the_set.sort_by(|a, b| a.0.total_cmp(&b.0));
    let others = in_the_set.into_iter().map(|(_, hypothesis)| hypothesis);
    (effects, std::iter::once(best.refitted.hypothesis.clone()).chain(others).collect())
}

#[cfg(test)]
mod tests {
    use plant::Model;

    use super::{Physics, moves_less};

    /// More inertia and less gain are one thing to a motion; what pulls at the axis, and what is less than relevant, is none of it.
    #[test]
    fn a_noisy_torque_seems_to_move_the_machine_less() {
        let machine = |inertia, torque_gain| Physics::new(Model { torque_gain, ..Model::new(inertia) });
        let band = machine(21.8, 1.0);
        for (own, less) in [((78.2, 1.0), true), ((21.8, 0.68), true), ((22.2, 1.0), false), ((20.0, 1.0), false)] {
            assert_eq!(moves_less(&machine(own.0, own.1), &band), less, "{own:?}");
        }
        let mut rubbed = band.clone();
        rubbed.model.coulomb = 18.4;
        assert!(!moves_less(&rubbed, &band));
    }
}
