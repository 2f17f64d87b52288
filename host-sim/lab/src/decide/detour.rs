//! Other ways to a model, where the best step at each turn ended nowhere.
//!
//! Of two effects that only explain the recordings together, neither predicts what is held out well alone, and a third that
//! is not there may predict better than both. The search takes one way; from another first step it may come to the end.

use super::Request;
use super::prepare::searcher;
use crate::effects::Effect;
use crate::screen::{Active, MIN_GAIN, Outcome, Problem, Refitter, SCALE};

/// A model that leaves less than this many times the noise, in mean squares, is an end.
const AN_END: f64 = 3.0;
/// So many other first steps are followed.
const WAYS: usize = 2;
/// Another model must leave less than this share of the held-out squares.
const SHORTER: f64 = 0.8;

/// The outcome of a search from the nominal machine, or a better one that does without the scale of the drive, begins with what
/// it came to miss most, or with another accepted effect.
pub(super) fn detour(request: &Request<'_>, problem: &Problem, mut first: Outcome) -> Outcome {
    let mut ways = std::mem::take(&mut first.first_step);
    let first = without_scale(request, problem, first);
    let at_an_end = |outcome: &Outcome| outcome.fit.sse < AN_END * outcome.fit.residual_count();
    if at_an_end(&first) {
        return first;
    }
    let first_way = ways.first().map(|way| way.effect);
    ways.retain(|way| !first.fit.active.iter().any(|entry| entry.effect == way.effect) && !way.effect.is_event());
    ways.sort_by(|a, b| a.fit.sse.total_cmp(&b.fit.sse));
    let ways = ways.into_iter().take(WAYS).map(|way| way.fit.active);
    // From the first step that was taken the search would go the same way again.
    let again = most_missed(problem, &first).filter(|entry| Some(entry.effect) != first_way);
    let ways: Vec<Vec<Active>> = again.map(|entry| vec![entry]).into_iter().chain(ways).collect();
    let mut best = first;
    for way in &ways {
        if problem.budget.check() {
            break;
        }
        let other = searcher(request, problem).run(way);
        if share_left(problem, &other, &best) < SHORTER {
            best = other;
        }
        if at_an_end(&best) {
            break;
        }
    }
    best
}

/// The outcome of a search that may not change the scale of the drive, where another's did and this predicts clearly better or
/// as well with fewer effects: positions and commands fix the balance up to one scale, and of the machines that one scale makes
/// alike the one with the fewest changes comes first.
fn without_scale(request: &Request<'_>, problem: &Problem, first: Outcome) -> Outcome {
    let scaled = first.fit.active.iter().any(|entry| entry.effect.id == SCALE);
    if !scaled || first.fit.active.len() < 2 || problem.budget.check() {
        return first;
    }
    let vocabulary: Vec<&'static Effect> =
        request.vocabulary.iter().copied().filter(|effect| effect.id != SCALE).collect();
    let other = searcher(&Request { vocabulary: &vocabulary, ..*request }, problem).run(&[]);
    let fewer = !other.fit.active.is_empty() && other.fit.active.len() < first.fit.active.len();
    let enough = if fewer { (1.0 - MIN_GAIN).powi(-2) } else { SHORTER };
    if share_left(problem, &other, &first) < enough { other } else { first }
}

/// The effect without which a model of several leaves most, alone: what was found beside something that is not there may be as
/// wrong as that.
fn most_missed(problem: &Problem, outcome: &Outcome) -> Option<Active> {
    let active = &outcome.fit.active;
    let refitter = Refitter::new(problem, outcome);
    let without = |index: usize| {
        let mut rest = active.clone();
        let entry = rest.remove(index);
        (refitter.fit(&rest).sse, entry)
    };
    let alone = (0..active.len()).map(without).max_by(|a, b| a.0.total_cmp(&b.0));
    alone.filter(|_| active.len() > 1).map(|(_, entry)| entry)
}

/// The share of the held-out squares of another that an outcome leaves, under the weights of either; the larger counts.
fn share_left(problem: &Problem, one: &Outcome, other: &Outcome) -> f64 {
    let shares = [one, other].map(|weights| {
        let refitter = Refitter::new(problem, weights);
        let heldout = |outcome: &Outcome| refitter.fit(&outcome.fit.active).heldout_sse();
        heldout(one) / heldout(other)
    });
    shares[0].max(shares[1])
}
