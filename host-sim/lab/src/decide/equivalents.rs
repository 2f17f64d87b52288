//! What these recordings cannot tell from the answer.

use crate::effects::Effect;
use crate::screen::{Fit, Refitter, worse};

/// How many are listed at most.
const LISTED: usize = 3;

/// Effects that, put in the place of one effect of the best model, predict not significantly worse: those of the fewest
/// parameters first, then by prediction. None has more parameters than the effect it replaces has.
pub fn equivalents(
    refitter: &Refitter<'_>,
    best: &Fit,
    index: usize,
    vocabulary: &[&'static Effect],
) -> Vec<&'static Effect> {
    let replaced = &best.active[index];
    let freedom = replaced.effect.freedom(&replaced.values);
    let mut rest = best.active.clone();
    rest.remove(index);
    let mut found: Vec<(usize, f64, &'static Effect)> = refitter
        .each_on(&rest, vocabulary)
        .into_iter()
        .filter(|(effect, _)| effect.id != replaced.effect.id)
        .filter_map(|(effect, fit)| {
            let entry = fit.active.last().filter(|entry| !entry.at_bound())?;
            let own = effect.freedom(&entry.values);
            (own <= freedom && !worse(&fit, best)).then(|| (own, fit.heldout_sse(), effect))
        })
        .collect();
    found.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    found.into_iter().take(LISTED).map(|(_, _, effect)| effect).collect()
}
