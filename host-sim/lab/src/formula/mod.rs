//! What no effect of the vocabulary explains, as a formula: a sparse sum of functions of state for the residual torque,
//! kept only if it predicts data it was not fitted to.
//!
//! Every function is averaged over the same bumps as the torque balance, so that the formula is consistent with the weak
//! form. Forward selection with exchanges, after orthogonal matching pursuit (Pati, Rezaiifar, Krishnaprasad 1993); each
//! step is judged as the screen judges an effect, by blocks left out and by recordings held out.

mod columns;
mod intervals;
mod select;
mod state;
mod terms;
#[cfg(test)]
mod tests;
mod words;

use crate::read::AxisKind;
use crate::report::Formula;
use crate::screen::{Fit, Outcome, Problem};
use columns::Columns;
use select::Selection;

/// A formula is reported if it takes at least this share of the held-out squares of the residual away, 1: in the blocks
/// left out, and in the recordings held out.
const MIN_SQUARES: f64 = 0.25;
/// A formula on top of the nominal machine alone comes before one on top of the best model, unless it leaves more by this
/// share of the nominal machine's held-out squares, 1.
const SIMPLER: f64 = 0.01;

/// The best sparse formula for what is missing, in place of every effect or beside those of the best model; none where
/// none predicts.
pub fn formula(problem: &Problem, outcome: &Outcome, axis: AxisKind) -> Option<Formula> {
    let alone = Candidate::new(problem, outcome, &outcome.nominal, axis);
    let beside =
        (!outcome.fit.active.is_empty()).then(|| Candidate::new(problem, outcome, &outcome.fit, axis)).flatten();
    let best = match (alone, beside) {
        (Some(alone), Some(beside)) if alone.left() - beside.left() > SIMPLER * outcome.nominal.heldout_sse() => beside,
        (Some(alone), Some(_)) => alone,
        (one, other) => one.or(other)?,
    };
    // A formula instead of effects that leaves more than they do is no answer.
    (best.left() < outcome.fit.heldout_sse()).then(|| best.answer(outcome, axis))
}

/// A formula on top of a model.
struct Candidate<'a> {
    base: &'a Fit,
    columns: Columns<'a>,
    selection: Selection,
}

impl<'a> Candidate<'a> {
    fn new(problem: &'a Problem, outcome: &'a Outcome, base: &'a Fit, axis: AxisKind) -> Option<Self> {
        let columns = Columns::new(problem, &outcome.weights, base);
        let selection = select::select(&columns, &terms::candidates(&columns, axis), axis)?;
        let kept = selection.held.squares_less(&columns.nothing()) >= MIN_SQUARES;
        kept.then_some(Self { base, columns, selection })
    }

    /// Held-out squares with the formula.
    fn left(&self) -> f64 {
        self.selection.held.total()
    }

    fn answer(&self, outcome: &Outcome, axis: AxisKind) -> Formula {
        let without = self.columns.nothing();
        let terms = intervals::terms(&self.columns, &self.selection.terms, axis);
        let mut on_top_of: Vec<String> = self.base.active.iter().map(|entry| entry.effect.id.to_owned()).collect();
        on_top_of.dedup();
        let floor = self.base.residual_count();
        Formula {
            text: words::sentence(&terms, &self.selection.terms, axis),
            on_top_of,
            heldout_gain: 1.0 - (self.left() / without.total().max(1e-300)).sqrt(),
            excess_explained: crate::decide::explained(outcome.nominal.sse, self.selection.sse, floor),
            terms,
        }
    }
}
