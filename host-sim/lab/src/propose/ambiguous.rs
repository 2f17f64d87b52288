//! The rivals of an answer that cannot choose.

use super::{Limits, Proposal, Request, Rival, best};
use crate::effects;
use crate::read::{Machine, Recording};
use crate::report::EffectAnswer;
use crate::residual::sensor_noise;
use crate::screen::{Outcome, Problem, Refitter};

/// Rivals at most; every pair of them costs time.
const RIVALS: usize = 4;

/// What to record next where the best model has effects with equivalents: the best model against itself with each such
/// effect swapped for its equivalents, best first. `floor_rms` is what noise alone leaves in the
/// windows, rad (m).
pub fn for_ambiguous(
    machine: &Machine,
    recordings: &[Recording],
    (problem, outcome): (&Problem, &Outcome),
    answers: &[EffectAnswer],
    floor_rms: f64,
) -> Option<Proposal> {
    let active = &outcome.fit.active;
    let id = |swapped: &str| {
        let mut others: Vec<&str> = active.iter().map(|entry| entry.effect.id).filter(|id| *id != swapped).collect();
        others.dedup();
        others.iter().fold(String::new(), |all, id| format!("{all} and {id}"))
    };
    let refitter = Refitter::new(problem, outcome);
    let mut rivals = Vec::new();
    for answer in answers.iter().filter(|answer| !answer.equivalent.is_empty()) {
        let Some(index) = active.iter().position(|entry| entry.effect.id == answer.id) else { continue };
        let rest = id(&answer.id);
        if rivals.is_empty() {
            let id = format!("{}{rest}", answer.id);
            rivals.push(Rival { id, base: problem.nominal.clone(), active: active.clone() });
        }
        let mut without = active.clone();
        without.remove(index);
        let others: Vec<_> = answer.equivalent.iter().filter_map(|id| effects::find(id)).collect();
        let fits = refitter.each_on(&without, &others);
        for (effect, fit) in others.iter().filter_map(|other| fits.iter().find(|(effect, _)| effect == other)) {
            let id = format!("{}{rest}", effect.id);
            // Two orders of cogging may have the same rival.
            if rivals.iter().all(|rival| rival.id != id) {
                rivals.push(Rival { id, base: problem.nominal.clone(), active: fit.active.clone() });
            }
        }
    }
    rivals.truncate(RIVALS);
    let count = recordings.len().max(1) as f64;
    let sensor_rms = recordings.iter().map(|recording| sensor_noise(recording, &machine.axis)).sum::<f64>() / count;
    let limits = Limits::of(machine, recordings);
    best(&Request { machine, rivals: &rivals, limits, sensor_rms, floor_rms })
}
