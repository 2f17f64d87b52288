//! From recordings to the answer.

use super::checks::self_checks;
use super::closest::closest;
use super::coincidence::{bent, coincidences, flat, held, may_be_no_gap, spread, undecided};
use super::confirmed::confirm;
use super::controller::mismatch;
use super::equivalents::contested;
use super::fitted::fit_answer;
use super::glitches::unnamed_glitches;
use super::named::{effects, rejected};
use super::prepare::{Searched, search};
use super::refined::Refined;
use super::simulated::shown;
use super::stretches::stretches;
use super::twin::Twins;
use super::verdict::{at_bound, not_told, verdict, warnings};
use std::sync::Arc;

use crate::Error;
use crate::budget::Budget;
use crate::effects::{Effect, Physics};
use crate::formula::formula;
use crate::locate::{first_unexplained, leftover, locations, regions, residual_map};
use crate::progress::Stages;
use crate::propose::{Proposal, for_ambiguous};
use crate::read::{Axis, Machine, Recording, position_step};
use crate::refit::{COARSEST_S, HORIZON_S, SETTLE_S};
use crate::report::{Answer, FirstUnexplained, Verdict};
use crate::residual::{horizon_s, median_period_s, no_window, spans};

/// Steps this many times those of the machine file are not its steps.
const COARSER: f64 = 1.5;

/// What is said where the budget ended the search.
const UNFINISHED: &str = "the work of one diagnosis was used up before everything was tried and refitted: the answer is what \
                          was found until then; shorter recordings, or fewer effects (--only), come to an end";
/// What is said where it ended the checks.
const UNCHECKED: &str = "the work of one diagnosis was used up before every check was made: the answer was not tried on a clean \
                         twin, and no experiment is proposed";

/// What is to be diagnosed.
#[derive(Debug)]
pub struct Request<'a> {
    /// The nominal model, with the effects it already has.
    pub machine: &'a Machine,
    /// Recordings to fit.
    pub recordings: &'a [Recording],
    /// Recordings that are only predicted; none to hold out blocks of the others.
    pub holdout: &'a [Recording],
    /// Effects that may be named.
    pub vocabulary: &'a [&'static Effect],
}

/// The answer with what it was drawn from.
#[derive(Debug)]
pub struct Diagnosis {
    /// As written to JSON.
    pub answer: Answer,
    /// The nominal machine.
    pub nominal: Physics,
    /// The improved machine.
    pub improved: Physics,
    /// What to record next, where the verdict is ambiguous.
    pub proposal: Option<Proposal>,
    /// How long each stage took.
    pub stages: Stages,
}

/// Diagnoses recordings.
///
/// # Errors
/// Recordings too short to say anything.
pub fn diagnose(request: &Request<'_>) -> Result<Diagnosis, Error> {
    diagnose_within(request, Budget::default())
}

/// Diagnoses recordings within a budget; where it is used up the answer is what was found until then, and says so.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_within(request: &Request<'_>, budget: Budget) -> Result<Diagnosis, Error> {
    let budget = Arc::new(budget);
    let first = Begun::new(request, &budget)?.decided(request)?;
    let second = if budget.check() { None } else { with_a_shaft(request, &first, &budget)? };
    Ok(second.unwrap_or(first))
}

/// The diagnosis with a flexible shaft in the place of a gap that may be none or is not told from a shaft, where that predicts
/// as well: such a gap is a shaft with one number more, which takes up what its wrong companions leave.
fn with_a_shaft(request: &Request<'_>, first: &Diagnosis, budget: &Arc<Budget>) -> Result<Option<Diagnosis>, Error> {
    const SHAFT: &str = "compliance";
    let effects = &first.answer.effects;
    let like_a_shaft =
        effects.iter().any(|effect| effect.id == "backlash" && effect.equivalent.iter().any(|id| id == SHAFT));
    if !(like_a_shaft || may_be_no_gap(effects)) || !request.vocabulary.iter().any(|effect| effect.id == SHAFT) {
        return Ok(None);
    }
    let vocabulary: Vec<&'static Effect> =
        request.vocabulary.iter().copied().filter(|effect| !effect.is_gap()).collect();
    let request = &Request { vocabulary: &vocabulary, ..*request };
    let begun = Begun::new(request, budget)?;
    // What the search does not find is not worth the time of a refit.
    if !begun.searched.outcome.fit.active.iter().any(|entry| entry.effect.id == SHAFT) {
        return Ok(None);
    }
    let second = begun.decided(request)?;
    if budget.check() {
        return Ok(None);
    }
    let named = second.answer.effects.iter().any(|effect| effect.id == SHAFT);
    Ok((named && second.answer.fit.heldout_after_rms <= first.answer.fit.heldout_after_rms).then_some(second))
}

/// A diagnosis under one vocabulary as far as the search brings it.
struct Begun {
    /// The nominal machine.
    nominal: Physics,
    /// The machine file with the step that the recordings show, where that is not the file's.
    coarser: Option<Machine>,
    searched: Searched,
    notes: Vec<String>,
    stages: Stages,
}

impl Begun {
    fn new(request: &Request<'_>, budget: &Arc<Budget>) -> Result<Self, Error> {
        let files: Vec<&Recording> = request.recordings.iter().chain(request.holdout).collect();
        let names: Vec<&str> = files.iter().map(|recording| recording.name.as_str()).collect();
        let nominal = Physics::of(request.machine, &names)?;
        let mut notes: Vec<String> = files.iter().flat_map(|recording| recording.notes()).collect();
        let coarser = coarser(request.machine, &files, &mut notes);
        let request = &Request { machine: coarser.as_ref().unwrap_or(request.machine), ..*request };
        files.iter().try_for_each(|file| windowed(file))?;
        let mut stages = Stages::begin();
        let searched = search(request, stretches(&files, &mut notes), (&nominal, budget), &mut stages);
        if searched.problem.fitted_equations() == 0 {
            let message = "nothing moves long enough in one direction to be judged; record more motion".to_owned();
            return Err(Error::Usage(format!("{}: {message}", names.join(", "))));
        }
        Ok(Self { nominal, coarser, searched, notes, stages })
    }

    fn decided(self, request: &Request<'_>) -> Result<Diagnosis, Error> {
        let Self { nominal, coarser, mut searched, mut notes, mut stages } = self;
        let files: Vec<&Recording> = request.recordings.iter().chain(request.holdout).collect();
        let request = &Request { machine: coarser.as_ref().unwrap_or(request.machine), ..*request };
        let Decided { refined, taken_back, alike } = decide(request, &mut searched, &mut notes, &mut stages);
        let controller = request.machine.controller.as_ref().and_then(|law| mismatch(law, &files, &mut notes));
        let (verdict, answer) = match controller {
            Some(effect) => (Verdict::Controller, vec![effect]),
            None => (Verdict::None, effects(request, &searched, &refined, &alike)),
        };
        stages.done("controller and evidence");
        let improved = searched.problem.machine(&refined.active);
        let mut diagnosis = Diagnosis {
            answer: Answer { schema: 1, verdict, effects: answer, ..Answer::default() },
            nominal,
            improved,
            proposal: None,
            stages,
        };
        judge(request, &searched, &refined, &mut diagnosis, notes)?;
        diagnosis.answer.rejected = rejected(request, &searched.outcome, &diagnosis.answer.effects, &taken_back);
        Ok(diagnosis)
    }
}

/// Whether a recording has windows to be diagnosed in.
fn windowed(file: &Recording) -> Result<(), Error> {
    let period_s = median_period_s(&file.t_s);
    if period_s > COARSEST_S * (1.0 + 1e-3) {
        return Err(Error::Usage(format!(
            "{}: a row every {:.0} ms is too coarse, at least one every {:.0} ms is needed; are the times in s?",
            file.name,
            1e3 * period_s,
            1e3 * COARSEST_S
        )));
    }
    let (horizon_s, settled_s) = (horizon_s(file, HORIZON_S), file.t_s[0] + SETTLE_S);
    let whole = spans(file, horizon_s).into_iter().any(|(start, _)| file.t_s[start] >= settled_s);
    if whole { Ok(()) } else { Err(Error::Usage(no_window(file, horizon_s))) }
}

/// The machine with the step that its recordings show, where that is clearly coarser than the file says.
fn coarser(machine: &Machine, files: &[&Recording], notes: &mut Vec<String>) -> Option<Machine> {
    let steps = files.iter().filter_map(|file| Some((position_step(&file.position)?, file.name.as_str())));
    let (step, name) = steps.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let resolution = machine.axis.resolution;
    (step > COARSER * resolution).then(|| {
        notes.push(format!(
            "{name}: the position moves in steps of {step:.3e}, not of {resolution:.3e} as the machine file has it; the former \
             is used"
        ));
        Machine { axis: Axis { resolution: step, ..machine.axis }, ..machine.clone() }
    })
}

/// The best model as simulation leaves it.
struct Decided {
    refined: Refined,
    /// Effects that the search found and simulation does not miss.
    taken_back: Vec<&'static Effect>,
    /// For each effect those that cannot be told from it.
    alike: Vec<Vec<&'static Effect>>,
}

/// What the search found, as far as simulation confirms it, with what only simulation shows.
fn decide(request: &Request<'_>, searched: &mut Searched, notes: &mut Vec<String>, stages: &mut Stages) -> Decided {
    let (mut refined, mut taken_back) = confirm(request, searched, notes);
    stages.done("refit");
    while let Some(shown) = shown(request, searched, &refined) {
        let count = searched.outcome.fit.active.len();
        searched.hold(shown);
        let (again, more) = confirm(request, searched, notes);
        refined = again;
        taken_back.extend(more);
        if searched.outcome.fit.active.len() <= count {
            break;
        }
    }
    stages.done("simulated effects");
    let (refined, alike) = contested(request, searched, refined, notes);
    searched.follow(&refined);
    stages.done("equivalents");
    Decided { refined, taken_back, alike }
}

/// The verdict and everything that depends on it.
fn judge(
    request: &Request<'_>,
    searched: &Searched,
    refined: &Refined,
    diagnosis: &mut Diagnosis,
    notes: Vec<String>,
) -> Result<(), Error> {
    let (problem, axis) = (&searched.problem, request.machine.axis.kind);
    let left = leftover(problem, &searched.outcome.fit, axis);
    let cut = problem.budget.check();
    let twins = Twins::of(request, searched, (&diagnosis.improved, refined.time.as_ref()));
    diagnosis.stages.done("twins");
    let Diagnosis { answer, nominal, improved, proposal, stages } = diagnosis;
    let (fit, floors) = fit_answer(request, searched, (nominal, improved), &mut answer.effects, &twins)?;
    answer.fit = fit;
    answer.effects.sort_by(|a, b| b.evidence.heldout_gain.total_cmp(&a.evidence.heldout_gain));
    stages.done("windows");
    let mut reasons = coincidences(problem, &answer.effects, improved, (request.vocabulary, axis));
    reasons.extend([bent, spread].into_iter().filter_map(|rule| rule(problem, &searched.outcome)));
    reasons.extend(undecided(problem, &searched.outcome, request.vocabulary));
    reasons.extend(unnamed_glitches(request, problem).filter(|_| answer.effects.is_empty()));
    reasons.extend(flat(problem, &searched.outcome, &answer.effects));
    reasons.extend(held(problem, &refined.active));
    reasons.extend(at_bound(&searched.outcome.fit.active, &refined.active));
    reasons.extend(not_told(&answer.effects, nominal, problem.motions.len()));
    reasons.extend(cut.then(|| UNFINISHED.to_owned()));
    if answer.verdict != Verdict::Controller {
        answer.verdict = verdict(searched, answer, &left, (&twins, &floors), &reasons);
    }
    answer.warnings = notes;
    answer.warnings.extend(reasons);
    answer.warnings.extend(warnings(searched, &left, answer.verdict));
    answer.warnings.extend(self_checks(problem, searched.fitted(), request.vocabulary));
    answer.warnings.extend(twins.warnings);
    answer.warnings.extend((!cut && problem.budget.check()).then(|| UNCHECKED.to_owned()));
    stages.done("self-checks");
    locate(searched, request, answer);
    stages.done("locate");
    if answer.verdict == Verdict::Ambiguous && !problem.budget.check() {
        let (found, floor_rms) = ((problem, &searched.outcome), answer.fit.noise_floor_rms);
        *proposal = for_ambiguous(request.machine, request.recordings, found, &answer.effects, floor_rms);
        answer.experiment = proposal.as_ref().map(Proposal::experiment);
        stages.done("propose");
    }
    Ok(())
}

/// Where the mismatch is; and where nothing explains it, all that can be said instead.
fn locate(searched: &Searched, request: &Request<'_>, answer: &mut Answer) {
    let axis = request.machine.axis.kind;
    let (problem, outcome) = (&searched.problem, &searched.outcome);
    if answer.verdict != Verdict::None {
        answer.regions = regions(problem, &outcome.nominal, axis);
        answer.locations = locations(problem, &outcome.nominal, axis, &answer.regions);
        answer.first_unexplained = first_unexplained(problem, &outcome.nominal);
        rows_of_files(searched, request, &mut answer.first_unexplained);
    }
    if answer.verdict == Verdict::Unknown {
        answer.residual_map = residual_map(problem, &outcome.fit, &outcome.weights, axis);
        answer.formula = formula(problem, outcome, axis);
        answer.closest = closest(searched, axis);
    }
}

/// Rows as the files count them, where a file was only looked at in stretches.
fn rows_of_files(searched: &Searched, request: &Request<'_>, first: &mut [FirstUnexplained]) {
    let files = request.recordings.iter().chain(request.holdout).zip(&searched.recordings);
    for (file, _) in files.filter(|(file, read)| read.rows() < file.rows()) {
        for first in first.iter_mut().filter(|first| first.recording == file.name) {
            first.row = file.t_s.partition_point(|t_s| *t_s < first.t_s) + 1;
        }
    }
}
