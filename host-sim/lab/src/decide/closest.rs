//! The effect of the vocabulary that comes closest where none explains what is missing.

use rayon::prelude::*;

use super::fitted::explained;
use super::prepare::Searched;
use crate::locate::regions;
use crate::read::AxisKind;
use crate::report::Closest;
use crate::screen::{Active, Fit, Refitter};

/// Less than this share of the excess left is nothing to point at, 1.
const LITTLE: f64 = 0.02;

/// The single effect that explains most of the excess, of those tried and those of the best model; none where nothing was
/// tried or nothing is above the noise.
pub(super) fn closest(searched: &Searched, axis: AxisKind) -> Option<Closest> {
    let (problem, outcome) = (&searched.problem, &searched.outcome);
    let refitter = Refitter::new(problem, outcome);
    let tried = outcome.trials.iter().map(|trial| (trial.effect.id, &trial.fit.active));
    let members = outcome.fit.active.iter().map(|entry| (entry.effect.id, &outcome.fit.active));
    // All entries of one effect, as orders of cogging, stand together; its values in the best model come first.
    let mut alone: Vec<(&str, Vec<Active>)> = Vec::new();
    for (id, active) in members.chain(tried) {
        if !alone.iter().any(|(known, _)| *known == id) {
            alone.push((id, active.iter().filter(|entry| entry.effect.id == id).cloned().collect()));
        }
    }
    let fits = alone.into_par_iter().map(|(id, entries)| (id, refitter.fit(&entries)));
    let (id, fit) = fits.min_by(|a, b| a.1.sse.total_cmp(&b.1.sse))?;
    let floor = fit.residual_count();
    if outcome.nominal.sse <= floor {
        return None;
    }
    let share = |fit: &Fit| explained(outcome.nominal.sse, fit.sse, floor).clamp(0.0, 1.0);
    let left = 1.0 - share(&fit);
    let region = regions(problem, &fit, axis).into_iter().next();
    // What is left is rounded up and what is explained down.
    let left_of = |share: f64| (100.0 * (1.0 - share) - 1e-9).ceil().max(0.0);
    let several = outcome.fit.active.len() > 1;
    let mut text = format!("{id} comes closest and leaves {:.0} % of the excess over the noise", left_of(share(&fit)));
    if several {
        let mut ids: Vec<&str> = outcome.fit.active.iter().map(|entry| entry.effect.id).collect();
        ids.dedup();
        text = format!(
            "together {} leave {:.0} % of the excess over the noise in the torque balance, and are not believed; of single \
             effects {text}",
            ids.join(" with "),
            left_of(share(&outcome.fit))
        );
    }
    if left < LITTLE {
        text +=
            ": the torque balance of what moves is in order, and what is missing shows in the simulated windows only";
    }
    if let Some(region) = region.as_ref().filter(|_| left >= LITTLE) {
        let (from, to) = (region.low, region.high);
        text += &format!(", {:.0} % of that at {} {from:.3} to {to:.3}", 100.0 * region.share, region.channel);
    }
    Some(Closest { id: id.to_owned(), excess_explained: share(&fit), left, region, text })
}
