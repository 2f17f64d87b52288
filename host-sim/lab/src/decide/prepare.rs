//! From recordings to the searched problem: the recorded torque made good, the motion smoothed with what was found.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use rayon::prelude::*;

use super::detour::detour;
use super::simulated::Shown;
use super::{Refined, Request};
use crate::Error;
use crate::budget::Budget;
use crate::effects::Physics;
use crate::progress::{Progress, Stages};
use crate::read::{AxisKind, Recording};
use crate::refit::{HORIZON_S, Windows};
use crate::screen::{Active, Motion, Outcome, Problem, Refitter, Search, effort_filter_s};

/// What was searched, and how it ended.
#[derive(Debug)]
pub(super) struct Searched {
    /// The equations.
    pub problem: Problem,
    /// The best model.
    pub outcome: Outcome,
    /// The recordings, to fit and then only to predict, with their torque made good.
    pub recordings: Vec<Recording>,
    /// Effects that simulation found.
    pub simulated: Vec<Shown>,
    /// Time constant of the filter that the recorded torque was measured behind, s.
    pub effort_filter_s: Option<f64>,
    /// What machines left of the windows of the recordings to fit: a load in its gap takes long, and is asked for often.
    seen: RefCell<Vec<(Physics, Rc<Windows>)>>,
}

impl Searched {
    /// The recordings to fit.
    pub(super) fn fitted(&self) -> &[Recording] {
        &self.recordings[..self.problem.fitted]
    }

    /// The windows of the recordings to fit, as an answer reports them.
    pub(super) fn windows(&self, request: &Request<'_>, machine: &Physics) -> Result<Rc<Windows>, Error> {
        if let Some((_, windows)) = self.seen.borrow().iter().find(|(seen, _)| seen == machine) {
            return Ok(Rc::clone(windows));
        }
        let resolution = request.machine.axis.resolution;
        let windows = Rc::new(Windows::new(machine, self.fitted(), 0, resolution, HORIZON_S)?);
        self.problem.budget.spend(windows.work);
        self.seen.borrow_mut().push((machine.clone(), Rc::clone(&windows)));
        Ok(windows)
    }

    /// Root mean square of the windows that effects leave of the recordings to fit, rad (m).
    pub(super) fn windows_rms(&self, request: &Request<'_>, active: &[Active]) -> Result<f64, Error> {
        self.windows(request, &self.problem.machine(active)).map(|windows| windows.rms())
    }

    /// The model with its held values where they are now.
    fn moved(&self, now: &[Active]) -> Vec<Active> {
        let pairs = self.outcome.fit.active.iter().zip(now);
        pairs.map(|(entry, now)| if entry.is_held() { now.held() } else { entry.clone() }).collect()
    }

    /// Takes an effect in that simulation found: it is held in the torque balance, which does not show it.
    pub(super) fn hold(&mut self, shown: Shown) {
        let Some((last, others)) = shown.active.split_last() else { return };
        let active: Vec<Active> = self.moved(others).into_iter().chain([last.held()]).collect();
        self.outcome.fit = Refitter::new(&self.problem, &self.outcome).at(&active);
        self.simulated.push(shown);
    }

    /// How simulation found an entry of the model; none where the torque balance did.
    pub(super) fn shown(&self, entry: &Active) -> Option<&Shown> {
        self.simulated.iter().find(|shown| entry.is_held() && shown.effect() == Some(entry.effect))
    }

    /// Held values as the refit left them.
    pub(super) fn follow(&mut self, refined: &Refined) {
        if !self.outcome.fit.active.iter().any(Active::is_held) {
            return;
        }
        self.outcome.fit = Refitter::new(&self.problem, &self.outcome).at(&self.moved(&refined.active));
    }
}

/// Searches twice: the smoother knew the nominal torques only; with those of the improved machine reversals are where they
/// were.
pub(super) fn search(
    request: &Request<'_>,
    mut recordings: Vec<Recording>,
    (nominal, budget): (&Physics, &Arc<Budget>),
    stages: &mut Stages,
) -> Searched {
    let linear = request.machine.axis.kind == AxisKind::Linear;
    let mut problem = problem(request, &recordings, nominal).within(budget);
    // Where the drive's delay, the fluid or the controller is known, the column is the command.
    let commanded = request.machine.controller.is_some() || nominal.damper.is_some() || nominal.torque_delay_s > 0.0;
    let filter = if commanded { None } else { effort_filter_s(&problem.motions[..problem.fitted], linear) };
    if let Some(filter_s) = filter {
        recordings.iter_mut().for_each(|recording| unfilter(recording, filter_s));
        problem = self::problem(request, &recordings, nominal).within(budget);
    }
    stages.done("prepare");
    let outcome = detour(request, &problem, searcher(request, &problem).run(&[]));
    stages.done("search");
    again(
        request,
        Searched {
            problem,
            outcome,
            recordings,
            simulated: Vec::new(),
            effort_filter_s: filter,
            seen: RefCell::default(),
        },
        nominal,
        stages,
    )
}

fn problem(request: &Request<'_>, recordings: &[Recording], nominal: &Physics) -> Problem {
    let resolution = request.machine.axis.resolution;
    let progress = Progress::new("preparing recordings", recordings.len() as u64);
    let prepared = recordings.par_iter().map(|recording| Motion::new(recording, nominal, resolution));
    let motions = prepared.inspect(|_| progress.advance(1)).collect();
    Problem::new(motions, request.recordings.len(), nominal.clone())
}

/// A search over a problem for what the request allows to name.
pub(super) fn searcher<'a>(request: &'a Request<'_>, problem: &'a Problem) -> Search<'a> {
    Search::new(problem, request.vocabulary, request.machine.axis.kind == AxisKind::Linear)
}

fn again(request: &Request<'_>, first: Searched, nominal: &Physics, stages: &mut Stages) -> Searched {
    let active = &first.outcome.fit.active;
    if active.is_empty() || first.problem.budget.check() {
        return first;
    }
    let found = first.problem.machine(active);
    let resolution = request.machine.axis.resolution;
    let motions = first.problem.motions.par_iter().enumerate().map(|(index, m)| m.again(&found, index, resolution));
    let problem = Problem::new(motions.collect(), request.recordings.len(), nominal.clone());
    let problem = problem.within(&first.problem.budget);
    stages.done("prepare");
    let outcome = searcher(request, &problem).run(active);
    stages.done("search");
    Searched { problem, outcome, ..first }
}

/// What acted, from what was measured behind a first-order filter: u + tau du/dt.
fn unfilter(recording: &mut Recording, filter_s: f64) {
    let (t_s, measured) = (&recording.t_s, recording.effort_cmd.clone());
    let last = measured.len() - 1;
    for (row, effort) in recording.effort_cmd.iter_mut().enumerate() {
        let (before, after) = (row.saturating_sub(1), (row + 1).min(last));
        if after > before {
            *effort += filter_s * (measured[after] - measured[before]) / (t_s[after] - t_s[before]);
        }
    }
}
