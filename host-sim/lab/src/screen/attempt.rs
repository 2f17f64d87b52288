//! One effect on top of a model: from its start values to its optimum.

use rayon::prelude::*;

use super::candidates::orders_left;
use super::fit::{Base, Fit, Fitter};
use super::judge::MIN_GAIN;
use super::problem::Active;
use super::search::{ITERATIONS, MAX_ENTRIES, Search};
use crate::effects::Effect;

/// Start values that are fitted to the end.
const FINALISTS: usize = 2;
/// A start whose first step leaves more than this share of the squares is not worth a fit to the end.
const HOPELESS: f64 = 0.985;
/// Start values that are felt out a little where there are kinks: the best of a coarse grid may stand in another valley.
const FELT: usize = 6;
/// Evaluations of that,
const SHORT: usize = 40;
/// and of a search without derivatives to the end.
const FEELS: usize = 120;

/// Whether the residual has kinks in the values, so that a derivative at the start says little about the optimum.
fn kinked(effect: &Effect) -> bool {
    effect.is_gap()
}

fn duplicate(active: &[Active], entry: &Active) -> bool {
    entry.effect.id == "cogging"
        && active.iter().any(|other| other.effect.id == "cogging" && (other.values[0] - entry.values[0]).abs() < 0.5)
}

impl Search<'_> {
    /// Whether the machine with some effects can have another.
    pub(super) fn applies(&self, active: &[Active], effect: &Effect) -> bool {
        (effect.applies)(&self.problem.machine(active), &self.excitation)
    }

    /// An effect with values, and the bounds that these recordings set.
    pub(super) fn entry(&self, effect: &'static Effect, values: Vec<f64>) -> Active {
        let ranges = effect.ranges(values.len(), &self.problem.nominal, &self.excitation);
        Active { effect, values, ranges }
    }

    /// Start values of an effect on top of others.
    pub(super) fn starts(&self, active: &[Active], effect: &'static Effect) -> Vec<Active> {
        let starts = (effect.starts)(&self.problem.machine(active), &self.excitation);
        starts.into_iter().map(|values| self.entry(effect, values)).collect()
    }

    /// The best values of an effect on top of a model.
    pub(super) fn attempt(&self, base: &Fit, known: &Base, effect: &'static Effect) -> Option<(Fit, usize)> {
        if !self.applies(&base.active, effect) {
            return None;
        }
        let fitter = self.fitter();
        let with = |entry: &Active| [base.active.as_slice(), std::slice::from_ref(entry)].concat();
        let mut starts = self.starts(&base.active, effect);
        starts.retain(|entry| !duplicate(&base.active, entry));
        let variants = starts.len();
        let glimpsed = if kinked(effect) {
            self.felt_out(base, starts)
        } else {
            let glimpse = |entry: Active| {
                let (sse, mut reached) = fitter.glimpse(&with(&entry), known);
                reached.pop().map(|entry| (sse, entry))
            };
            let mut glimpsed: Vec<(f64, Active)> = starts.into_iter().filter_map(glimpse).collect();
            glimpsed.sort_by(|a, b| a.0.total_cmp(&b.0));
            glimpsed
        };
        let (finalists, iterations) = match glimpsed.first() {
            Some((sse, _)) if *sse > HOPELESS * base.sse => (1, 2),
            _ => (FINALISTS, ITERATIONS),
        };
        let finalists = glimpsed.iter().take(finalists);
        let fits = finalists.map(|(_, entry)| fitter.fit_on(&with(entry), iterations, known));
        let best = fits.filter(Fit::is_finite).min_by(|a, b| a.sse.total_cmp(&b.sse))?;
        Some((best, variants))
    }

    /// Of start values, best first, those that are worth a fit, as far as a search without derivatives brings them. Where nothing
    /// on the grid is better than none of it, or nothing felt out is worth a fit, the rest is not worth the time.
    fn felt_out(&self, base: &Fit, starts: Vec<Active>) -> Vec<(f64, Active)> {
        let problem = self.problem.to_fit();
        let fitter = Fitter { problem: &problem, weights: &self.weights[..problem.equations.len()] };
        let known = fitter.base(base);
        let feel = |entry: Active, evaluations: usize| {
            let (sse, mut reached) = fitter.feel(&[base.active.as_slice(), &[entry]].concat(), &known, evaluations);
            reached.pop().map(|entry| (sse, entry))
        };
        let mut felt: Vec<(f64, Active)> = starts.into_iter().filter_map(|entry| feel(entry, 1)).collect();
        felt.sort_by(|a, b| a.0.total_cmp(&b.0));
        felt.truncate(if felt.first().is_some_and(|best| best.0 < base.sse) { FELT } else { 1 });
        let better = |felt: &&mut (f64, Active)| felt.0 < base.sse;
        felt.par_iter_mut().filter(better).for_each(|felt| lower(felt, feel(felt.1.clone(), SHORT)));
        felt.sort_by(|a, b| a.0.total_cmp(&b.0));
        felt.truncate(FINALISTS);
        let promising = |felt: &&mut (f64, Active)| felt.0 < HOPELESS * base.sse;
        felt.par_iter_mut().filter(promising).for_each(|felt| feel_on(&fitter, base, &known, felt));
        felt
    }

    /// Cogging is one effect of several orders: adds them while each predicts better.
    pub(super) fn more_orders(&self, base: &Fit, first: Fit, effect: &'static Effect) -> Fit {
        let fitter = self.fitter();
        let mut best = first;
        if 1.0 - (best.heldout_sse() / base.heldout_sse()).sqrt() < 0.5 * MIN_GAIN {
            return best;
        }
        while best.active.len() < MAX_ENTRIES {
            let raw: Vec<f64> = best.residual.iter().zip(&self.weights).map(|(r, w)| r / w).collect();
            let orders = orders_left(self.problem, &raw, &self.excitation);
            let size = 0.02 * self.excitation.torque_rms;
            let entry = orders.first().map(|&order| self.entry(effect, vec![order, size, size]));
            let Some(entry) = entry.filter(|entry| !duplicate(&best.active, entry)) else { break };
            let known = fitter.base(&best);
            let more = fitter.fit_on(&[best.active.as_slice(), &[entry]].concat(), ITERATIONS, &known);
            let gain = 1.0 - (more.heldout_sse() / best.heldout_sse()).sqrt();
            if gain < MIN_GAIN || !more.is_finite() {
                break;
            }
            best = more;
        }
        best
    }
}

/// Goes on from a start without derivatives, with a scan between two passes.
fn feel_on(fitter: &Fitter<'_>, base: &Fit, known: &Base, felt_out: &mut (f64, Active)) {
    let start = [base.active.as_slice(), std::slice::from_ref(&felt_out.1)].concat();
    let (_, felt) = fitter.feel(&start, known, FEELS);
    let (_, scanned) = fitter.scan(&felt, known);
    let (sse, mut reached) = fitter.feel(&scanned, known, FEELS);
    lower(felt_out, reached.pop().map(|entry| (sse, entry)));
}

/// Takes what was found where it leaves less.
fn lower(felt_out: &mut (f64, Active), found: Option<(f64, Active)>) {
    if let Some(found) = found.filter(|found| found.0 < felt_out.0) {
        *felt_out = found;
    }
}
