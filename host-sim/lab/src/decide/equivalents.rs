//! What these recordings cannot tell from the answer, and what simulation tells better than the torque balance.

use super::confirmed::confirm;
use super::prepare::Searched;
use super::{Refined, Request};
use crate::effects::Effect;
use crate::refit::TimeFit;
use crate::screen::{Active, Fit, Refitter, WORSE_T, fall_t, worse};

/// How many are listed at most.
const LISTED: usize = 3;
/// An effect whose held-out squares in the torque balance are no more than this many times the best model's is simulated too:
/// the bumps blur what is finer than they are.
const NEAR: f64 = 1.5;
/// So many of them for each effect.
const SIMULATED: usize = 2;
/// Simulated, a rival is as good whose fall to the best has no more than this t.
const AS_GOOD_T: f64 = 0.5;
/// Mean square of the residual in units of its noise above which it is not noise alone.
const NOISE: f64 = 2.0;
/// A rival of an event may leave this share of what the event explains.
const SHORT: f64 = 0.1;
/// Exchanges at most.
const EXCHANGES: usize = 2;

/// An effect in the place of one of the best model.
struct Rival {
    effect: &'static Effect,
    fit: Fit,
}

/// Exchanges effects for those that simulate better, or as well with fewer values, and gives for each effect of the model that
/// is left those that predict not significantly worse in its place: those of the fewest parameters first, then by prediction.
pub(super) fn contested(
    request: &Request<'_>,
    searched: &mut Searched,
    refined: Refined,
    notes: &mut Vec<String>,
) -> (Refined, Vec<Vec<&'static Effect>>) {
    let mut refined = refined;
    for turn in 0..=EXCHANGES {
        let refitter = Refitter::new(&searched.problem, &searched.outcome);
        let mut alike = Vec::new();
        let mut better = None;
        for index in 0..searched.outcome.fit.active.len() {
            if searched.problem.budget.check() {
                return (refined, alike);
            }
            let entry = &searched.outcome.fit.active[index];
            if let Some(shown) = searched.shown(entry) {
                alike.push(shown.alike.clone());
                continue;
            }
            let mut rivals = rivals(&refitter, &searched.outcome.fit, index, request.vocabulary);
            let Simulated { better: found, as_good } = simulated(searched, &refined, index, &mut rivals);
            better = better.or_else(|| found.filter(|_| turn < EXCHANGES));
            let event = searched.outcome.fit.active[index].effect.is_event();
            let most = if event { explains_as_much(&refitter, &searched.outcome.fit, index) } else { f64::INFINITY };
            let alike_to = |rival: &Rival| !worse(&rival.fit, &searched.outcome.fit) || as_good.contains(&rival.effect);
            rivals.retain(|rival| alike_to(rival) && rival.fit.sse <= most);
            alike.push(rivals.into_iter().take(LISTED).map(|rival| rival.effect).collect());
        }
        let Some(active) = better else { return (refined, alike) };
        // What simulation found stays where it put it.
        let by_simulation =
            |entry: &Active| searched.simulated.iter().any(|shown| shown.effect() == Some(entry.effect));
        let active: Vec<Active> =
            active.iter().map(|entry| if by_simulation(entry) { entry.held() } else { entry.clone() }).collect();
        let fit = refitter.fit(&active);
        searched.outcome.fit = fit;
        (refined, _) = confirm(request, searched, notes);
    }
    (refined, Vec::new())
}

/// The squares up to which a rival explains about as much as one effect does: an event is in one block, and no scatter over
/// blocks tells who is worse.
fn explains_as_much(refitter: &Refitter<'_>, best: &Fit, index: usize) -> f64 {
    let mut rest = best.active.clone();
    rest.remove(index);
    best.sse + SHORT * (refitter.fit(&rest).sse - best.sse)
}

/// Every effect that may stand in the place of one of the best model and needs no more parameters, best first.
fn rivals(refitter: &Refitter<'_>, best: &Fit, index: usize, vocabulary: &[&'static Effect]) -> Vec<Rival> {
    let replaced = &best.active[index];
    let freedom = replaced.effect.freedom(&replaced.values);
    let mut rest = best.active.clone();
    rest.remove(index);
    let each = refitter.each_on(&rest, vocabulary).into_iter();
    let mut found: Vec<(usize, Rival)> = each
        .filter(|(effect, _)| effect.id != replaced.effect.id)
        .filter_map(|(effect, fit)| {
            let entry = fit.active.last().filter(|_| !fit.at_bound())?;
            let own = effect.essential(&entry.values);
            (own <= freedom).then_some((own, Rival { effect, fit }))
        })
        .collect();
    found.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.fit.heldout_sse().total_cmp(&b.1.fit.heldout_sse())));
    found.into_iter().map(|(_, rival)| rival).collect()
}

/// Whether a rival needs fewer values than what it would replace.
fn simpler(replaced: &Active, rival: Option<&Active>) -> bool {
    let values = |entry: &Active| entry.effect.essential(&entry.values);
    rival.is_some_and(|rival| values(rival) < values(replaced))
}

/// What simulation says of rivals.
#[derive(Default)]
struct Simulated {
    /// The effects with the one that is better, or as good and simpler.
    better: Option<Vec<Active>>,
    /// Those that are as good, whatever the torque balance says: a hundredth of its squares may be its own error.
    as_good: Vec<&'static Effect>,
}

/// Simulates the nearest rivals of one effect where the best model itself was, and takes those out that are worse.
fn simulated(searched: &Searched, refined: &Refined, index: usize, rivals: &mut Vec<Rival>) -> Simulated {
    let (problem, best) = (&searched.problem, &searched.outcome.fit);
    // What is left must be noise, or squares are no measure of what is likely.
    let noise = best.sse <= NOISE * best.residual_count() && !problem.machine(&best.active).remembers();
    let Some(time) = refined.time.as_ref().filter(|_| noise) else { return Simulated::default() };
    let recordings = searched.fitted();
    let limit = NEAR * best.heldout_sse();
    let mut near: Vec<usize> = (0..rivals.len()).filter(|&rank| rivals[rank].fit.heldout_sse() < limit).collect();
    near.sort_by(|&a, &b| rivals[a].fit.heldout_sse().total_cmp(&rivals[b].fit.heldout_sse()));
    near.truncate(SIMULATED);
    let mut better: Option<TimeFit> = None;
    let (mut dropped, mut as_good) = (Vec::new(), Vec::new());
    for rank in near {
        if problem.budget.check() {
            break;
        }
        let mut active = time.active.clone();
        active.remove(index);
        active.extend(rivals[rank].fit.active.last().cloned());
        if problem.machine(&active).remembers() {
            continue;
        }
        let Ok(fit) = time.rival(problem, recordings, &active) else { continue };
        let worse_t = fall_t(&fit.heldout, &time.heldout);
        if worse_t < AS_GOOD_T {
            as_good.push(rivals[rank].effect);
            if simpler(&time.active[index], fit.active.last()) && !worse(&rivals[rank].fit, best) {
                better.get_or_insert(fit);
                continue;
            }
        }
        if worse_t > WORSE_T {
            dropped.push(rivals[rank].effect);
        } else if fall_t(&time.heldout, &fit.heldout) > WORSE_T
            && fit.sse < better.as_ref().map_or(time.sse, |other| other.sse)
        {
            better = Some(fit);
        }
    }
    rivals.retain(|rival| !dropped.contains(&rival.effect));
    Simulated { better: better.map(|fit| fit.active), as_good }
}
