//! The diagnosis: recordings in, a conclusion of the crate `diagnosis`, the answer out.

mod answer;
mod controller;
mod files;
mod lost;
mod stretches;
mod values;
mod whitened;

use diagnosis::effects::{Effect, VOCABULARY, find};
use diagnosis::physics::Physics;
use diagnosis::pipeline::{Conclusion, diagnose_as_read};
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use diagnosis::verdict::Verdict as Judged;
use diagnosis::work::WORK;

use self::controller::mismatch;
pub use self::files::{OfFiles, of_files, of_recordings};
use self::lost::Lost;
use self::stretches::stretches;
pub use self::whitened::Whitened;
use crate::Error;
use crate::asked::{likelier, recorded};
use crate::progress::{Course, End, Place, Stages};
use crate::propose::{self, Limits, Proposal};
use crate::read::vocabulary::CONTROLLER;
use crate::read::{Axis, AxisKind, Machine, Recording, misspelt, position_step};
use crate::report::{Answer, Units, Verdict};

/// Steps of the position this many times those of the machine file are not its steps.
const COARSER: f64 = 1.5;
/// Fewest rows of a recording that a filter settles on and still has something to say.
const FEWEST_ROWS: usize = 40;

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
    /// The nominal machine; its pushes and phases are numbered as the recordings to fit and then those held out.
    pub nominal: Physics,
    /// The machine of the best hypothesis, numbered likewise.
    pub improved: Physics,
    /// What each recording, as far as it was looked at, leaves of both machines.
    pub whitened: Vec<Whitened>,
    /// What to record next, where the verdict is ambiguous.
    pub proposal: Option<Proposal>,
    /// How long each stage took.
    pub stages: Stages,
}

/// That there is no effect `id`, with the one that it is probably a misspelling of.
pub fn unknown_effect(id: &str) -> Error {
    let near = misspelt(id, VOCABULARY.iter().map(|effect| effect.id));
    let near = near.map_or_else(String::new, |near| format!("; the nearest is `{near}`"));
    Error::Usage(format!("there is no effect `{id}`{near}; `servo-lab help effects` lists them"))
}

/// The effects that may be named: those of `only`, all where it is empty, but those of `without`.
///
/// # Errors
/// A name that is no effect.
pub fn vocabulary(only: &[String], without: &[String]) -> Result<Vec<&'static Effect>, Error> {
    for id in only.iter().chain(without) {
        if find(id).is_none() && id != CONTROLLER {
            return Err(unknown_effect(id));
        }
    }
    let has = |ids: &[String], effect: &Effect| ids.iter().any(|id| id == effect.id);
    let may_be_named = |effect: &&Effect| (only.is_empty() || has(only, effect)) && !has(without, effect);
    Ok(VOCABULARY.iter().copied().filter(|effect| may_be_named(effect)).collect())
}

/// Diagnoses recordings with the likelihood as the only judge.
///
/// # Errors
/// Recordings too short to say anything, a machine that cannot be simulated.
pub fn diagnose(request: &Request<'_>) -> Result<Diagnosis, Error> {
    diagnose_on(request, &Course::unseen())
}

/// The same, which shows how far it is.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_on(request: &Request<'_>, course: &Course) -> Result<Diagnosis, Error> {
    course.enter("preparing");
    let files: Vec<&Recording> = request.recordings.iter().chain(request.holdout).collect();
    if let Some(short) = files.iter().find(|file| file.rows() < FEWEST_ROWS) {
        let rows = short.rows();
        return Err(Error::Usage(format!(
            "{}: {rows} rows are too few to diagnose; record at least {FEWEST_ROWS}",
            short.name
        )));
    }
    let mut notes: Vec<String> = files.iter().flat_map(|file| file.notes()).collect();
    notes.extend(unscaled(request.machine));
    let mut stages = Stages::begin();
    let controller = request.machine.controller.as_ref().and_then(|law| mismatch(law, &files, &mut notes));
    stages.done("controller");
    let lost = Lost::of(request.machine, &files);
    let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    let machine = with_steps_of(request.machine, &files, &mut notes);
    let problem = problem(&machine, request, &files, &mut notes);
    stages.done("prepare");
    course.watch(searching(&problem));
    let (problem, conclusion) = diagnose_as_read(problem, request.vocabulary).ok_or_else(|| {
        Error::Usage(format!("{}: the nominal machine cannot be followed along these recordings", names.join(", ")))
    })?;
    stages.done("search, refit and confidence set");
    course.enter("answer");
    let mut answer = answer::answer(&problem, &conclusion, machine.axis.kind);
    if let Some(lost) = lost.filter(|_| problem.motions.is_empty()) {
        notes.push(lost.note());
        lost.doubt(&mut answer);
    }
    match controller {
        Some(effect) => (answer.verdict, answer.effects) = (Verdict::Controller, vec![effect]),
        None => {
            answer.alternatives = values::alternatives(&problem, &conclusion, machine.axis.kind);
            answer.correlation = values::correlation(&conclusion, machine.axis.kind);
        }
    }
    answer.warnings = notes;
    stages.done("answer");
    // What another log of the same motion would show needs no other motion.
    let ambiguous = conclusion.verdict == Judged::Ambiguous;
    let proposal = if ambiguous { proposal(&machine, request, &problem, &conclusion, course) } else { None };
    answer.experiment = proposal.as_ref().map(Proposal::experiment);
    answer.warnings.extend(answer::warnings(&problem, &conclusion, answer.experiment.is_some()));
    stages.done("propose");
    course.enter("what is left");
    let improved = conclusion.physics(&problem);
    let whitened = whitened::all(&problem, &conclusion);
    Ok(Diagnosis { answer, improved, nominal: problem.nominal, whitened, proposal, stages })
}

/// That nobody has said what the current or voltage of the logs makes.
fn unscaled(machine: &Machine) -> Option<String> {
    let unit = machine.columns.unscaled_effort()?;
    let own = Units::of(machine.axis.kind).effort;
    Some(format!(
        "how many {own} one {unit} makes is not known (`scale` in [columns] is 1 or -1): every {own} of this answer is one {unit}"
    ))
}

/// Passes over the recordings that a diagnosis usually is in all: the median of 49 tuning cases was 1900, half of them between 900 and 2800.
const USUAL_PASSES: u64 = 1900;

/// How far the search and the estimate are: a diagnosis seldom takes all the work that it may.
fn searching(problem: &Problem) -> impl Fn() -> Place + Send + Sync + 'static {
    let tally = problem.tally().clone();
    let begun = tally.done();
    let usually = begun + WORK.min(USUAL_PASSES * problem.substeps());
    let end = End::AtMost { steps: begun + WORK, usually, to: "the verdict" };
    move || Place { stage: if tally.is_estimating() { "estimate" } else { "search" }, done: tally.done(), end }
}

/// Rivals at most that an experiment is chosen for; every one of them costs time.
const RIVALS: usize = 4;

/// The recording that tells the hypotheses of the set apart.
fn proposal(
    machine: &Machine,
    request: &Request<'_>,
    problem: &Problem,
    conclusion: &Conclusion,
    course: &Course,
) -> Option<Proposal> {
    let rivals = conclusion.in_the_set.get(..RIVALS).unwrap_or(&conclusion.in_the_set);
    let noise = *conclusion.best.assessed.refitted.noise.first()?;
    let (limits, as_commands) = (Limits::of(machine, request.recordings), problem.motions.is_empty());
    propose::best_on(&propose::Request { machine, rivals, limits, noise, as_commands }, course)
}

/// The machine with the step that its recordings show, where that is clearly coarser than the file says.
fn with_steps_of(machine: &Machine, files: &[&Recording], notes: &mut Vec<String>) -> Machine {
    let steps = files.iter().filter_map(|file| Some((position_step(&file.position)?, file.name.as_str())));
    let coarsest = steps.max_by(|a, b| a.0.total_cmp(&b.0));
    let resolution = machine.axis.resolution;
    match coarsest {
        Some((step, name)) if step > COARSER * resolution => {
            notes.push(format!(
                "{name}: the position moves in steps of {step:.3e}, not of {resolution:.3e} as the machine file has it; the \
                 former is used"
            ));
            Machine { axis: Axis { resolution: step, ..machine.axis }, ..machine.clone() }
        }
        _ => machine.clone(),
    }
}

fn problem(machine: &Machine, request: &Request<'_>, files: &[&Recording], notes: &mut Vec<String>) -> Problem {
    let read = stretches(files, notes);
    let names: Vec<&str> = read.iter().map(|file| file.name.as_str()).collect();
    let nominal = Physics::nominal(machine, &names);
    let linear = machine.axis.kind == AxisKind::Linear;
    let of = |recorded: Vec<Recorded>| {
        let problem =
            Problem::new(nominal.clone(), recorded, request.recordings.len(), machine.axis.resolution, linear);
        problem.sampled(machine.axis.sample_period_s)
    };
    let columns = of(read.iter().map(Recorded::new).collect());
    likelier(columns, || of(read.iter().map(|file| recorded(machine, file)).collect()))
}
