//! Models refitted under the weights that a search ended with.

use rayon::prelude::*;

use super::fit::Fit;
use super::judge::{inflation, p_value};
use super::problem::{Active, Problem};
use super::search::{ITERATIONS, Outcome, Search, conflicts, full};
use crate::effects::Effect;

/// Refits models under fixed weights, after the search.
#[derive(Debug)]
pub struct Refitter<'a> {
    search: Search<'a>,
}

impl<'a> Refitter<'a> {
    /// Under the weights and with the candidates that a search ended with.
    pub fn new(problem: &'a Problem, outcome: &Outcome) -> Self {
        Self { search: Search::resumed(problem, outcome) }
    }

    /// The optimum of a set of effects from their values.
    pub fn fit(&self, active: &[Active]) -> Fit {
        self.search.fitter().fit(active, ITERATIONS)
    }

    /// A set of effects at its values.
    pub fn at(&self, active: &[Active]) -> Fit {
        self.search.fitter().fit(active, 0)
    }

    /// Whether an effect may stand beside others and this machine can have it.
    pub fn may_join(&self, active: &[Active], effect: &'static Effect) -> bool {
        let beside = !active.iter().any(|entry| conflicts(entry.effect, effect)) && !full(active, effect);
        beside && self.search.applies(active, effect)
    }

    /// An effect with values, and the bounds that these recordings set.
    pub fn entry(&self, effect: &'static Effect, values: Vec<f64>) -> Active {
        self.search.entry(effect, values)
    }

    /// Start values of an effect on top of others.
    pub fn starts(&self, active: &[Active], effect: &'static Effect) -> Vec<Active> {
        self.search.starts(active, effect)
    }

    /// Each effect that fits on top of a set, at their common optimum.
    pub fn each_on(&self, active: &[Active], vocabulary: &[&'static Effect]) -> Vec<(&'static Effect, Fit)> {
        let base = self.fit(active);
        let known = self.search.fitter().base(&base);
        let open = vocabulary.par_iter().copied().filter(|effect| {
            !base.active.iter().any(|entry| conflicts(entry.effect, effect)) && !full(&base.active, effect)
        });
        open.filter_map(|effect| self.search.attempt(&base, &known, effect).map(|(fit, _)| (effect, fit))).collect()
    }

    /// p-value of the last effects of `fit` on top of `base`, uncorrected.
    pub fn p_value(&self, base: &Fit, fit: &Fit) -> f64 {
        p_value(self.search.problem, base, fit)
    }

    /// How many neighbouring equations of a fit count as one.
    pub fn inflation(&self, fit: &Fit) -> f64 {
        inflation(self.search.problem, &fit.residual)
    }
}
