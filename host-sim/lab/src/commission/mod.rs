//! Commissioning in one go: record, identify, diagnose, tune, set, verify.

mod report;
mod step;

pub use report::text;
pub use step::Figures;

use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use er_servo::Config;
use er_servo::experiment::{Experiment, Shape};

use crate::Error;
use crate::conclude::{self, Request};
use crate::identify::{Event, Identified, Plan, Told, applied, identify, machine};
use crate::progress::Course;
use crate::read::{EffectEntry, Machine, Recording};
use crate::report::Answer;
use crate::session::Session;
use crate::stability::NormalisedGains;
use crate::tune::{Demands, Steps, Task, summary, tune};

/// What is to be done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    /// How far and how hard the axis may move.
    pub plan: Plan,
    /// The step by which the loop is judged before and after, rad.
    pub step_rad: f32,
    /// The parameters go to the drive's flash where the step is good.
    pub save: bool,
}

/// What was done.
#[derive(Debug, Clone)]
pub struct Commissioned {
    /// Parameters of the drive before.
    pub before: Config,
    /// The tuned ones.
    pub after: Config,
    /// Step with the parameters before.
    pub step_before: (Recording, Figures),
    /// Step with the tuned ones.
    pub step_after: (Recording, Figures),
    /// The machine by experiments.
    pub identified: Identified,
    /// What the diagnosis says of that machine's model.
    pub answer: Answer,
    /// What it names beyond the model, all of it in the machine file.
    pub named: Vec<EffectEntry>,
    /// What the tuning says of the gains.
    pub tuning: String,
    /// The machine file, with the tuned parameters.
    pub machine: Machine,
    /// Whether the drive keeps the tuned parameters; else it has those before.
    pub kept: bool,
    /// Whether they are in its flash too.
    pub saved: bool,
}

/// Duration of a step, s: five times what the slowest machine of the ranges takes to settle.
const STEP_S: f32 = 1.5;
/// A tuned step may settle so much slower than the one before, a factor: noise of a single step.
const NO_SLOWER: f64 = 1.1;
/// By how much each delay may be off, shares, the first that gains can bear: what `tune` asks for by default, of delays that
/// nobody need have measured, and less, as these are measured to a hundredth and only drift.
const UNCERTAINTIES: [f64; 4] = [0.5, 0.4, 0.3, 0.2];
/// Largest overshoot of the tuned step, share: what `tune` allows by default, and as much again for what no model has.
const MOST_OVERSHOOT: f64 = 0.04;

/// Does it all. The drive ends with the tuned parameters, or, where the step is not good, with those before.
///
/// # Errors
///
/// A drive that refuses or trips, Ctrl-C, no room for the motion, recordings that do not determine the machine, demands that no
/// gains keep, `told`; the drive has its parameters back then.
pub fn commission(session: &mut Session, wanted: &Wanted, told: &mut Told) -> Result<Commissioned, Error> {
    let before = session.config()?;
    let (up_rad, down_rad) = wanted.plan.room_rad();
    session.has_room(&before, up_rad + 2.0 * wanted.step_rad, down_rad)?;
    let outcome = commissioned(session, wanted, &before, told);
    if matches!(&outcome, Ok(Commissioned { kept: true, .. })) { outcome } else { session.restored(&before, outcome) }
}

fn commissioned(
    session: &mut Session,
    wanted: &Wanted,
    before: &Config,
    told: &mut Told,
) -> Result<Commissioned, Error> {
    told(Event::Stage("a step as it is"))?;
    let recorded_before = step(session, BEFORE, wanted, told)?;
    let identified = identify(session, &wanted.plan, told)?;
    told(Event::Stage("diagnoses what the model leaves out"))?;
    let mut machine = machine(before, &identified);
    let answer = left_out(session, &machine, &identified, &recorded_before)?;
    let named = lasting(&machine, &answer);
    machine.effects.extend(named.iter().cloned());
    told(Event::Stage("tunes"))?;
    let (machine, tuning) = tuned(session, machine, &applied(before, &identified), wanted)?;
    let after = machine.controller.unwrap_or(*before);
    session.set_all(&after)?;
    told(Event::Stage("the step again"))?;
    let recorded_after = step(session, AFTER, wanted, told)?;
    let coulomb_nm = identified.steady.coulomb_nm.value;
    let figures_before = figures(&recorded_before, before, coulomb_nm)?;
    let figures_after = figures(&recorded_after, &after, coulomb_nm)?;
    let kept = is_good(&figures_before, &figures_after);
    let saved = kept && wanted.save;
    if saved {
        session.save()?;
    }
    Ok(Commissioned {
        before: *before,
        after,
        step_before: (recorded_before, figures_before),
        step_after: (recorded_after, figures_after),
        identified,
        answer,
        named,
        tuning,
        machine,
        kept,
        saved,
    })
}

/// Recordings of the step, as files are called.
pub const BEFORE: &str = "step-before.csv";
/// The same with the tuned parameters.
pub const AFTER: &str = "step-after.csv";

fn step(session: &mut Session, name: &str, wanted: &Wanted, told: &mut Told) -> Result<Recording, Error> {
    let shape = Shape::Step { amplitude_rad: wanted.step_rad };
    let recording = session.experiment(name, Experiment { shape, duration_s: STEP_S }, wanted.plan.max_torque_nm)?;
    told(Event::Recorded(&recording))?;
    Ok(recording)
}

fn figures(recording: &Recording, config: &Config, coulomb_nm: f64) -> Result<Figures, Error> {
    let none = || Error::Usage(format!("{}: holds no step", recording.name));
    Figures::of(recording, coulomb_nm / f64::from(config.kp_nm_rad)).ok_or_else(none)
}

fn is_good(before: &Figures, after: &Figures) -> bool {
    let settles = match (before.settling_s, after.settling_s) {
        (_, None) => false,
        (None, Some(_)) => true,
        (Some(before_s), Some(after_s)) => after_s <= NO_SLOWER * before_s,
    };
    settles && after.overshoot <= MOST_OVERSHOOT.max(before.overshoot)
}

/// What the dynamic recordings, judged on the step, say is missing in the machine.
fn left_out(session: &Session, machine: &Machine, identified: &Identified, step: &Recording) -> Result<Answer, Error> {
    // Each recording has parameters of its own, and the link has compared none of them: the physics only.
    let machine = Machine { controller: None, ..machine.clone() };
    let recordings: Vec<Recording> = identified.moved().cloned().collect();
    let holdout = [step.clone()];
    let diagnosed = session.computed(move || {
        let (recordings, holdout) = (&recordings[..], &holdout[..]);
        let request = Request { machine: &machine, recordings, holdout, vocabulary: &VOCABULARY };
        conclude::diagnose_on(&request, &Course::begin("diagnosis")).map(|diagnosis| diagnosis.answer)
    });
    diagnosed?
}

/// What the answer adds to a machine where it is believed; what happens once is no part of one.
fn lasting(machine: &Machine, answer: &Answer) -> Vec<EffectEntry> {
    let believed = answer.verdict.is_certain();
    let is_new = |id: &str| machine.effects.iter().all(|there| there.id != id);
    let effects = answer.effects.iter().filter(|effect| believed && effect.recording.is_none() && is_new(&effect.id));
    let entry = |effect: &crate::report::EffectAnswer| EffectEntry {
        id: effect.id.clone(),
        recording: None,
        parameters: effect.parameters.iter().map(|parameter| (parameter.id.clone(), parameter.value)).collect(),
    };
    effects.map(entry).collect()
}

/// The machine with tuned gains, and what the tuning says of them: how far the delays may be off is part of it.
fn tuned(session: &Session, machine: Machine, config: &Config, wanted: &Wanted) -> Result<(Machine, String), Error> {
    let tasks = UNCERTAINTIES.map(|uncertainty| Task { uncertainty, ..task(&machine, config, wanted) });
    let search = move || {
        let mut last = None;
        for task in tasks {
            match tune(&task) {
                Ok(tuning) => return Ok((task, tuning)),
                Err(error) => last = Some(error),
            }
        }
        Err(last.unwrap_or_else(|| Error::Usage("nothing was searched".to_owned())))
    };
    let (task, tuning) = session.computed(search)??;
    Ok((crate::tune::machine(&task, &tuning, Some(machine)), summary(&task, &tuning)))
}

/// As `servo-lab tune` asks by default, with the step that is verified.
fn task(machine: &Machine, config: &Config, wanted: &Wanted) -> Task {
    let model = Physics::nominal(machine, &[]).model;
    let large_rad = f64::from(wanted.step_rad.abs());
    let paper = NormalisedGains::PAPER.physical(model.inertia, model.torque_delay_s.max(1e-3));
    let held_rad = model.coulomb / paper.k_p_nm_rad;
    Task {
        model,
        config: *config,
        demands: Demands { phase_deg: 30.0, gain: 1.5, delay_share: 0.2 },
        uncertainty: 0.5,
        q1_nm_s_rad: None,
        steps: Steps {
            large_rad,
            small_rad: 0.05,
            tolerance_rad: (0.02 * large_rad).max(2.0 * held_rad),
            overshoot: 0.02,
        },
    }
}
