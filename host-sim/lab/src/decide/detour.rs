//! Other ways to a model, where the best step at each turn ended nowhere.
//!
//! Of two effects that only explain the recordings together, neither predicts what is held out well alone, and a third that
//! is not there may predict better than both. The search takes one way; from another first step it may come to the end.

use super::Request;
use super::prepare::searcher;
use crate::screen::{Outcome, Problem, Refitter};

/// A model that leaves less than this many times the noise, in mean squares, is an end.
const AN_END: f64 = 3.0;
/// So many other first steps are followed.
const WAYS: usize = 2;
/// Another model must leave less than this share of the held-out squares.
const SHORTER: f64 = 0.8;

/// The outcome of a search from the nominal machine, or a better one that begins with another accepted effect.
pub(super) fn detour(request: &Request<'_>, problem: &Problem, first: Outcome) -> Outcome {
    let at_an_end = |outcome: &Outcome| outcome.fit.sse < AN_END * outcome.fit.residual_count();
    if at_an_end(&first) {
        return first;
    }
    let mut ways = searcher(request, problem).first_step();
    ways.retain(|way| !first.fit.active.iter().any(|entry| entry.effect == way.effect) && !way.effect.is_event());
    ways.sort_by(|a, b| a.fit.sse.total_cmp(&b.fit.sse));
    let mut best = first;
    for way in ways.iter().take(WAYS) {
        let other = searcher(request, problem).run(&way.fit.active);
        if leaves_less(problem, &other, &best) {
            best = other;
        }
        if at_an_end(&best) {
            break;
        }
    }
    best
}

/// Whether an outcome predicts clearly better than another, under the weights of either.
fn leaves_less(problem: &Problem, one: &Outcome, other: &Outcome) -> bool {
    [one, other].into_iter().all(|weights| {
        let refitter = Refitter::new(problem, weights);
        let heldout = |outcome: &Outcome| refitter.fit(&outcome.fit.active).heldout_sse();
        heldout(one) < SHORTER * heldout(other)
    })
}
