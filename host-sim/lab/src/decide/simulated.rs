//! Effects that the torque balance of what moves does not show: what happens at standstill, and a push against a rotor that
//! holds. They are looked for by simulation, in the windows that the best model leaves far from the recording.

use rayon::prelude::*;

use super::confirmed::{improvement, needs};
use super::fitted::explained;
use super::prepare::Searched;
use super::{Refined, Request};
use crate::effects::{Effect, Physics, Pulse};
use crate::refit::{Event, Probe, TimeFit};
use crate::report::Evidence;
use crate::screen::{Active, Refitter, WORSE_T, t_of_mean};

/// Effects whose signature is at standstill.
const AT_REST: [&str; 3] = ["stribeck_friction", "presliding", "er_preyield"];
/// Start values that leave more than this share of the far windows are not worth a fit to everything.
const PROMISES: f64 = 0.93;
/// So many effects are fitted to everything.
const FINALISTS: usize = 2;
/// What is found so must lower the reported windows to this share: by less, stick and slip differ by accident.
const FALLS_TO: f64 = 0.9;
/// Twice the logarithm of how much less likely an effect is that is worse than another, where one event decides.
const WORSE_SSE: f64 = 20.0;

/// An effect that simulation shows, and those that it cannot be told from.
#[derive(Debug)]
pub(super) struct Shown {
    /// All effects, the new one last.
    pub active: Vec<Active>,
    /// Best first.
    pub alike: Vec<&'static Effect>,
}

impl Shown {
    /// The new one.
    pub(super) fn effect(&self) -> Option<&'static Effect> {
        self.active.last().map(|entry| entry.effect)
    }
}

/// The effect that mends the far windows of a refined model best; none where few are far or nothing mends them.
pub(super) fn shown(request: &Request<'_>, searched: &Searched, refined: &Refined) -> Option<Shown> {
    let (problem, resolution) = (&searched.problem, request.machine.axis.resolution);
    // Bristles and loads whose state is not known well make windows far by themselves.
    if problem.machine(&refined.active).remembers() || problem.budget.check() {
        return None;
    }
    let recordings = searched.fitted();
    let own;
    let base = match &refined.time {
        Some(time) => time,
        None => {
            own = TimeFit::new(problem, recordings, &refined.active, resolution).ok()?;
            &own
        }
    };
    let probe = Probe::new(problem, recordings, base)?;
    let before = probe.loss(&base.active)?;
    let mut tried = candidates(request, searched, &probe, base);
    tried.retain(|(loss, _)| *loss < PROMISES * before);
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    let finalists = tried.into_iter().take(FINALISTS).take_while(|_| !problem.budget.check());
    let fits = finalists.filter_map(|(_, active)| base.rival(problem, recordings, &active).ok());
    let mut fits: Vec<TimeFit> =
        fits.filter(|fit| gains(base, fit) && !fit.active.iter().any(Active::at_bound)).collect();
    fits.sort_by(|a, b| a.sse.total_cmp(&b.sse));
    let best = fits.first()?;
    let rms = |active: &[Active]| searched.windows_rms(request, active);
    if rms(&best.active).ok()? > FALLS_TO * rms(&base.active).ok()? {
        return None;
    }
    let last = |fit: &TimeFit| fit.active.last().map(|entry| entry.effect);
    let alike = fits.iter().skip(1).filter(|fit| !is_worse(fit, best)).filter_map(last).collect();
    Some(Shown { active: best.active.clone(), alike })
}

/// What each effect leaves of the far windows from its best start, with the effects it is on top of.
fn candidates(
    request: &Request<'_>,
    searched: &Searched,
    probe: &Probe<'_>,
    base: &TimeFit,
) -> Vec<(f64, Vec<Active>)> {
    let refitter = Refitter::new(&searched.problem, &searched.outcome);
    // Several pushes are no event any more.
    let again = |effect: &Effect| base.active.iter().any(|entry| entry.effect == effect);
    let open = request.vocabulary.iter().filter(|effect| !again(effect) && refitter.may_join(&base.active, effect));
    let open = open.take_while(|_| !searched.problem.budget.check());
    open.filter_map(|effect| best_start(searched, &refitter, probe, base, effect)).collect()
}

/// Whether a fit is worth its last effect.
fn gains(base: &TimeFit, fit: &TimeFit) -> bool {
    fit.active.last().is_some_and(|entry| needs(base, fit, entry.effect))
}

fn is_worse(fit: &TimeFit, best: &TimeFit) -> bool {
    let changes: Vec<f64> = fit.heldout.iter().zip(&best.heldout).map(|(a, b)| a - b).collect();
    t_of_mean(&changes) > WORSE_T || fit.sse - best.sse > WORSE_SSE
}

/// What the best start values of an effect leave of the far windows, with the effects they are on top of.
fn best_start(
    searched: &Searched,
    refitter: &Refitter<'_>,
    probe: &Probe<'_>,
    base: &TimeFit,
    effect: &'static Effect,
) -> Option<(f64, Vec<Active>)> {
    let machine = searched.problem.machine(&base.active);
    if effect.is_event() {
        let with = |pulse: &Pulse| {
            let values = vec![pulse.recording as f64, pulse.start_s, pulse.duration_s, pulse.amplitude];
            [base.active.as_slice(), &[refitter.entry(effect, values)]].concat()
        };
        return probe.push(with, |event| hold(searched, &machine, event));
    }
    if !AT_REST.contains(&effect.id) {
        return None;
    }
    let starts = starts(refitter, base, &machine, effect);
    let losses = starts.into_par_iter().filter_map(|entry| {
        let active = [base.active.as_slice(), &[entry]].concat();
        Some((probe.loss(&active)?, active))
    });
    losses.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Start values; an excess over Coulomb friction begins as a share of it, down to speeds that no moving window resolves.
fn starts(refitter: &Refitter<'_>, base: &TimeFit, machine: &Physics, effect: &'static Effect) -> Vec<Active> {
    let usual = refitter.starts(&base.active, effect);
    let Some(fastest) = usual.last().filter(|_| effect.id == "stribeck_friction" && machine.coulomb > 0.0) else {
        return usual;
    };
    let (fastest, coulomb) = (fastest.values[1], machine.coulomb);
    let speeds = [0.01, 0.03, 0.1, 0.3].map(|part| part * fastest);
    let shares = [0.1, 0.4].map(|share| share * coulomb);
    shares.iter().flat_map(|&excess| speeds.map(|speed| refitter.entry(effect, vec![excess, speed]))).collect()
}

/// Least torque that holds the rotor during an event, N m (N): dry friction and the damper's level.
fn hold(searched: &Searched, machine: &Physics, event: &Event) -> f64 {
    let motion = &searched.problem.motions[event.recording];
    let row = |t_s: f64| motion.t_s.partition_point(|t| *t < t_s).min(motion.t_s.len() - 1);
    let (from, to) = (row(event.start_s), row(event.end_s));
    let field = motion
        .field
        .as_ref()
        .map_or(0.0, |field| field[from..=to].iter().fold(f64::INFINITY, |least, e| least.min(*e)));
    let fluid = machine.damper.as_ref().map_or(0.0, |damper| damper.scale * (damper.a * field + damper.b) * field);
    machine.coulomb + fluid.max(0.0)
}

/// Of a push: earliest and latest start, shortest and longest duration that simulation allows, s. A rotor that holds does
/// not show when a push began.
pub(super) fn reach(searched: &Searched, refined: &Refined, index: usize) -> Option<[(f64, f64); 2]> {
    let time = refined.time.as_ref()?;
    Probe::around(&searched.problem, searched.fitted(), time, index)?.reach(&refined.active, index)
}

/// Evidence of an effect that the torque balance does not show, from simulation; none where it was not refitted there.
pub(super) fn evidence(searched: &Searched, refined: &Refined, index: usize) -> Option<Evidence> {
    let with = refined.time.as_ref()?;
    let without = with.without(&searched.problem, searched.fitted(), index).ok()?;
    let heldout = |fit: &TimeFit| fit.heldout.iter().sum::<f64>();
    Some(Evidence {
        heldout_gain: 1.0 - (heldout(with) / heldout(&without).max(1e-300)).sqrt(),
        p_value: (improvement(&without, with) * searched.outcome.variants as f64).min(1.0),
        excess_explained: explained(without.sse, with.sse, with.freedom),
    })
}
