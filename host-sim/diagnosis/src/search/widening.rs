//! Effects of which one is a wider form of the other start from each other's refit: a gap and a shaft.

use rayon::prelude::*;

use crate::effects::Effect;
use crate::hypothesis::{Hypothesis, Refitted, refit, with_likelier_neighbour};
use crate::likelihood::Noise;
use crate::problem::Problem;
use crate::score::as_it_starts;

use super::around::{Extended, Odds, STEPS};

/// Of some starts of an effect beside a hypothesis the likeliest on the excerpts.
pub(super) fn likeliest(
    problem: &Problem,
    hypothesis: &Hypothesis,
    effect: &'static Effect,
    starts: Vec<Vec<f64>>,
    noise: &[Noise],
) -> Option<Vec<f64>> {
    let score = |values: Vec<f64>| {
        let physics = hypothesis.with(effect, values.clone()).physics(&problem.nominal);
        Some((as_it_starts(problem, &physics, noise)?, values))
    };
    let best = starts.into_par_iter().filter_map(score).max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(best.1)
}

/// An effect in the place of an entry whose own it widens, or is a wider form of it, from that one's optimum; none for any other, or where
/// no work is left.
pub(super) fn nested(problem: &Problem, best: &Refitted, at: usize, effect: &'static Effect) -> Option<Extended> {
    let own = &best.hypothesis.entries[at];
    let starts = match (effect.widens, own.effect.widens) {
        (Some(of), _) if of.narrower == own.effect => (of.wider)(&own.values, &problem.excitation),
        (_, Some(of)) if of.narrower == effect => vec![(of.within)(&own.values)],
        _ => return None,
    };
    let odds = Odds { tries: starts.len() as f64, ..Odds::of_one() };
    let without = best.hypothesis.without(at);
    let values = likeliest(problem, &without, effect, starts, &best.noise).filter(|_| !problem.is_spent())?;
    let found = refit(problem, &without.with(effect, values), &best.noise, STEPS)?;
    let refitted = with_likelier_neighbour(problem, &found, without.entries.len()).unwrap_or(found);
    let open = if problem.is_spent() { f64::INFINITY } else { 0.0 };
    Some(Extended { refitted, odds, open })
}
