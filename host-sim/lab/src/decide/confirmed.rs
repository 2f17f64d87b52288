//! Effects that the time domain does not confirm are taken back.
//!
//! The weak form is a model of the recording too, and where the noise is small its own errors look like a small effect. The
//! plant has no such errors: what is there makes its windows worse when it is left out.

use super::gap;
use super::prepare::Searched;
use super::twin::{Noise, estimate, noise_floor};
use super::{Refined, Request};
use crate::Error;
use crate::effects::Effect;
use crate::refit::TimeFit;
use crate::screen::{Active, MAX_P, MIN_T, Refitter, paired_t, tail};

/// An effect whose part in the prediction is larger is no error of the weak form.
const PLAIN: f64 = 0.3;
/// What is there shows in the windows as they are reported too, not only in their white noise.
const FALLS_TO: f64 = 0.995;
/// A gap is four values that bend to any roughness; it must be worth them,
const GAP_FALLS_TO: f64 = 0.9;
/// and without it the windows must leave this many times what the sensor alone leaves of them: the start states of a load take
/// up what a coarse one rounds away, where nothing is missing too.
const GAP_ABOVE: f64 = 1.05;

/// Refits what the search found, takes back what the windows do not miss, and gives what is left with what was taken back.
pub(super) fn confirm(
    request: &Request<'_>,
    searched: &mut Searched,
    notes: &mut Vec<String>,
) -> (Refined, Vec<&'static Effect>) {
    let mut taken_back = Vec::new();
    loop {
        if let Some(index) = insignificant(searched) {
            taken_back.push(take_back(searched, index));
            continue;
        }
        let refined = refine(request, searched, notes);
        let Some(index) = unconfirmed(request, searched, &refined) else {
            return (refined, taken_back);
        };
        taken_back.push(take_back(searched, index));
    }
}

fn take_back(searched: &mut Searched, index: usize) -> &'static Effect {
    let mut rest = searched.outcome.fit.active.clone();
    let effect = rest.remove(index).effect;
    searched.outcome.fit = Refitter::new(&searched.problem, &searched.outcome).fit(&rest);
    effect
}

/// An effect that was significant when it was found, and is not beside those that were found later.
fn insignificant(searched: &Searched) -> Option<usize> {
    let outcome = &searched.outcome;
    let refitter = Refitter::new(&searched.problem, outcome);
    let mut free = (0..outcome.fit.active.len()).filter(|&index| !outcome.fit.active[index].is_held());
    free.find(|&index| {
        let mut rest = outcome.fit.active.clone();
        rest.remove(index);
        refitter.p_value(&refitter.fit(&rest), &outcome.fit) * outcome.variants as f64 >= MAX_P
    })
}

/// The effects found, with values from the time domain where it holds.
fn refine(request: &Request<'_>, searched: &Searched, notes: &mut Vec<String>) -> Refined {
    let (problem, refitter) = (&searched.problem, Refitter::new(&searched.problem, &searched.outcome));
    let inflation = refitter.inflation(&searched.outcome.fit);
    let resolution = request.machine.axis.resolution;
    let mut fit = searched.outcome.fit.clone();
    // What the torque balance holds is free where it is simulated.
    for entry in fit.active.iter_mut().filter(|entry| entry.is_held()) {
        *entry = refitter.entry(entry.effect, entry.values.clone());
    }
    let refined = Refined::new(problem, searched.fitted(), &fit, inflation, resolution, notes);
    gap::settled(request, searched, refined)
}

/// The weakest of the effects that simulation does as well without.
fn unconfirmed(request: &Request<'_>, searched: &Searched, refined: &Refined) -> Option<usize> {
    let (problem, fit) = (&searched.problem, &searched.outcome.fit);
    if problem.budget.check() {
        return None;
    }
    let refitter = Refitter::new(problem, &searched.outcome);
    let rms = |active: &[Active]| searched.windows_rms(request, active);
    let falls = |without: &[Active], to: f64| -> bool {
        rms(without).and_then(|before| Ok(rms(&refined.active)? < to * before)).unwrap_or(true)
    };
    let rest = |index: usize| {
        let mut rest = fit.active.clone();
        rest.remove(index);
        refitter.fit(&rest)
    };
    // A load that bounces in its gap is where no window can know: neither its slopes nor its squares are to be believed,
    // but the whole must come nearer.
    if let Some(gap) = gap::gap(&fit.active) {
        let rest = rest(gap).active;
        let confirmed = falls(&rest, GAP_FALLS_TO) && above_sensor(request, searched, &rest, GAP_ABOVE).unwrap_or(true);
        return (!confirmed).then_some(gap);
    }
    let gain = |index: usize| 1.0 - (fit.heldout_sse() / rest(index).heldout_sse().max(1e-300)).sqrt();
    let mut weak: Vec<(usize, f64)> = (0..fit.active.len()).map(|index| (index, gain(index))).collect();
    weak.retain(|(_, gain)| *gain < PLAIN);
    weak.sort_by(|a, b| a.1.total_cmp(&b.1));
    weak.into_iter().map(|(index, _)| index).find(|&index| {
        let Some(time) = &refined.time else { return !falls(&rest(index).active, FALLS_TO) };
        let Ok(without) = time.without(problem, searched.fitted(), index) else { return false };
        !needs(&without, time, fit.active[index].effect) || !falls(&without.active, FALLS_TO)
    })
}

/// Whether effects leave so many times what noise and steps of the sensor alone would leave of the windows of the recordings
/// to fit. The torque's noise is left out: the balance of a load in its gap has errors of its own, at impacts.
fn above_sensor(request: &Request<'_>, searched: &Searched, active: &[Active], times: f64) -> Result<bool, Error> {
    let (problem, outcome, resolution) = (&searched.problem, &searched.outcome, request.machine.axis.resolution);
    let machine = problem.machine(active);
    let noise = |index| Noise { torque: 0.0, ..estimate(problem, &outcome.fit, &outcome.weights, index, resolution) };
    let noises: Vec<Noise> = (0..problem.fitted).map(noise).collect();
    let floor = noise_floor(&machine, searched.fitted(), &problem.motions, &noises)?;
    problem.budget.spend(floor.work);
    let windows = searched.windows(request, &machine)?;
    Ok(floor.under(&windows, 0).is_none_or(|above| above.exceeded(windows.rms(), times)))
}

/// p-value of what a fit in the time domain gains over a smaller one.
pub(super) fn improvement(without: &TimeFit, with: &TimeFit) -> f64 {
    let values = |fit: &TimeFit| fit.scores.first().map_or(0, |score| score.len());
    let added = values(with).saturating_sub(values(without)).max(1) as f64;
    let left = (with.freedom - values(with) as f64).max(1.0);
    let statistic = (without.sse - with.sse).max(0.0) / added / (with.sse / left).max(1e-300);
    tail(added, left, statistic)
}

/// Whether a fit in the time domain needs an effect that another has not. No block but its own misses an event.
pub(super) fn needs(without: &TimeFit, with: &TimeFit, effect: &Effect) -> bool {
    if effect.is_event() { improvement(without, with) < MAX_P } else { missed(without, with) }
}

/// Whether a fit in the time domain is missed in a smaller one: over all, and over blocks that were left out.
pub(super) fn missed(without: &TimeFit, with: &TimeFit) -> bool {
    improvement(without, with) < MAX_P && paired_t(&without.heldout, &with.heldout) >= MIN_T
}
