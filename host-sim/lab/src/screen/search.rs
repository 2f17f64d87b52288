//! Forward, exchange and backward steps over the vocabulary, judged by blocks left out.

use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::candidates::{excitation, orders_left, spans, stands_out};
use super::fit::{Fit, Fitter};
use super::noise::deviations;
use super::problem::{Active, Problem};
use crate::effects::{Effect, Excitation};

/// Least gain in held-out error for an effect to be accepted.
pub const MIN_GAIN: f64 = 0.03;
/// Largest p-value, after correction for every variant tried.
pub const MAX_P: f64 = 1e-3;
/// Least t of the improvement over blocks: what a few neighbouring residuals share is no evidence.
const MIN_T: f64 = 3.0;
/// Effects of a combination at most, orders of cogging counted as one.
const MAX_EFFECTS: usize = 4;
/// Entries at most: several orders of cogging are one effect.
const MAX_ENTRIES: usize = 7;
/// Start values that are fitted to the end.
const FINALISTS: usize = 2;
/// Evaluations of a search without derivatives.
const FEELS: usize = 120;
/// Iterations of a fit.
const ITERATIONS: usize = 12;

/// The one effect that is an event.
const PULSE: &str = "disturbance_pulse";

/// An effect tried on top of others.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Which.
    pub effect: &'static Effect,
    /// All effects together at their optimum; the tried one is the last.
    pub fit: Fit,
    /// Relative fall of the held-out root mean square.
    pub gain: f64,
    /// Of the improvement, corrected for every variant tried.
    pub p_value: f64,
    /// t of the held-out improvement, paired over blocks; infinite for an event, which is in one block only.
    pub t: f64,
}

impl Trial {
    /// Whether it passes all tests.
    pub fn accepted(&self) -> bool {
        self.gain >= MIN_GAIN && self.p_value < MAX_P && self.t >= MIN_T
    }
}

/// Where the search ended.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The best model.
    pub fit: Fit,
    /// The nominal machine under the same weights.
    pub nominal: Fit,
    /// Weight of each equation: one over its noise.
    pub weights: Vec<f64>,
    /// Each effect of the vocabulary on top of the model it was last tried on, best first.
    pub trials: Vec<Trial>,
    /// Sizes and candidates of the last step.
    pub excitation: Excitation,
    /// Number of variants fitted or glimpsed.
    pub variants: usize,
}

/// Effects that change the same numbers cannot stand together.
fn conflicts(a: &Effect, b: &Effect) -> bool {
    const GROUPS: [&[&str]; 3] = [
        &["field_lag", "field_lag_asymmetry"],
        &[
            "viscosity_dead_time",
            "viscosity_lag",
            "field_dead_time",
            "field_lag",
            "field_lag_asymmetry",
            "field_slew_limit",
        ],
        &["compliance", "backlash"],
    ];
    if a.id == b.id {
        return !matches!(a.id, "cogging" | PULSE);
    }
    let viscosity = |e: &Effect| e.id.starts_with("viscosity");
    GROUPS
        .iter()
        .enumerate()
        .any(|(group, ids)| ids.contains(&a.id) && ids.contains(&b.id) && (group != 1 || viscosity(a) || viscosity(b)))
}

/// Whether the residual has kinks in the values, so that a derivative at the start says little about the optimum.
fn kinked(effect: &Effect) -> bool {
    effect.id == "backlash"
}

fn duplicate(active: &[Active], entry: &Active) -> bool {
    entry.effect.id == "cogging"
        && active.iter().any(|other| other.effect.id == "cogging" && (other.values[0] - entry.values[0]).abs() < 0.5)
}

fn full(active: &[Active], effect: &Effect) -> bool {
    let mut ids: Vec<&str> = active.iter().map(|entry| entry.effect.id).chain([effect.id]).collect();
    ids.sort_unstable();
    ids.dedup();
    ids.len() > MAX_EFFECTS || active.len() >= MAX_ENTRIES
}

/// Refits models under fixed weights, after the search.
#[derive(Debug)]
pub struct Refitter<'a> {
    search: Search<'a>,
}

impl<'a> Refitter<'a> {
    /// Under the weights and with the candidates that a search ended with.
    pub fn new(problem: &'a Problem, outcome: &Outcome) -> Self {
        let (weights, excitation) = (outcome.weights.clone(), outcome.excitation.clone());
        Self {
            search: Search { problem, vocabulary: &[], linear: excitation.linear, weights, excitation, variants: 0 },
        }
    }

    /// The optimum of a set of effects from their values.
    pub fn fit(&self, active: &[Active]) -> Fit {
        self.search.fitter().fit(active, ITERATIONS)
    }

    /// Each effect that fits on top of a set, at their common optimum.
    pub fn each_on(&self, active: &[Active], vocabulary: &[&'static Effect]) -> Vec<(&'static Effect, Fit)> {
        let base = self.fit(active);
        let open = vocabulary.par_iter().copied().filter(|effect| {
            !base.active.iter().any(|entry| conflicts(entry.effect, effect)) && !full(&base.active, effect)
        });
        open.filter_map(|effect| self.search.attempt(&base, effect).map(|(fit, _)| (effect, fit))).collect()
    }

    /// p-value of the last effects of `fit` on top of `base`, uncorrected.
    pub fn p_value(&self, base: &Fit, fit: &Fit) -> f64 {
        p_value(self.search.problem, base, fit)
    }

    /// How many neighbouring equations of a fit count as one.
    pub fn inflation(&self, fit: &Fit) -> f64 {
        inflation(self.search.problem, fit)
    }
}

/// Searches a vocabulary over the recordings of a problem.
#[derive(Debug)]
pub struct Search<'a> {
    problem: &'a Problem,
    vocabulary: &'a [&'static Effect],
    linear: bool,
    weights: Vec<f64>,
    excitation: Excitation,
    variants: usize,
}

impl<'a> Search<'a> {
    /// A search from the nominal machine.
    pub fn new(problem: &'a Problem, vocabulary: &'a [&'static Effect], linear: bool) -> Self {
        let weights = vec![1.0; problem.equations.len()];
        let mut search = Self { problem, vocabulary, linear, weights, excitation: Excitation::default(), variants: 0 };
        search.weigh(&[]);
        search
    }

    /// New weights and candidates from what is left by a model.
    fn weigh(&mut self, active: &[Active]) {
        let machine = self.problem.machine(active);
        let raw = self.problem.residual(&self.problem.parts(&machine, None));
        self.excitation = excitation(self.problem, &machine, &raw, self.linear);
        self.weights = deviations(self.problem, &raw, machine.inertia).iter().map(|s| 1.0 / s).collect();
    }

    fn fitter(&self) -> Fitter<'_> {
        Fitter { problem: self.problem, weights: &self.weights }
    }

    /// The best values of an effect on top of a model.
    fn attempt(&self, base: &Fit, effect: &'static Effect) -> Option<(Fit, usize)> {
        let machine = self.problem.machine(&base.active);
        if !(effect.applies)(&machine, &self.excitation) {
            return None;
        }
        let fitter = self.fitter();
        let known = fitter.base(base);
        let mut starts: Vec<Active> = (effect.starts)(&machine, &self.excitation)
            .into_iter()
            .map(|values| {
                let ranges = effect.ranges(values.len(), &self.problem.nominal, &self.excitation);
                Active { effect, values, ranges }
            })
            .filter(|entry| !duplicate(&base.active, entry))
            .collect();
        let variants = starts.len();
        let with = |entry: &Active| [base.active.as_slice(), std::slice::from_ref(entry)].concat();
        if starts.len() > FINALISTS {
            let mut scored: Vec<(f64, Active)> = starts
                .iter()
                .filter_map(|entry| {
                    let (sse, mut reached) = if kinked(effect) {
                        fitter.feel(&with(entry), &known, 1)
                    } else {
                        fitter.glimpse(&with(entry), &known)
                    };
                    reached.pop().map(|entry| (sse, entry))
                })
                .collect();
            scored.sort_by(|a, b| a.0.total_cmp(&b.0));
            if kinked(effect) {
                // Where nothing on the grid is better than none of it, the rest is not worth the time.
                scored.truncate(if scored.first().is_some_and(|best| best.0 < base.sse) { FINALISTS } else { 1 });
                for (sse, entry) in scored.iter_mut().filter(|scored| scored.0 < base.sse) {
                    let (low, mut reached) = fitter.feel(&with(entry), &known, FEELS);
                    if let Some(found) = reached.pop().filter(|_| low < *sse) {
                        (*sse, *entry) = (low, found);
                    }
                }
            }
            starts = scored.into_iter().take(FINALISTS).map(|(_, entry)| entry).collect();
        }
        let fits = starts.iter().map(|entry| fitter.fit_on(&with(entry), ITERATIONS, &known));
        let best = fits.min_by(|a, b| a.sse.total_cmp(&b.sse))?;
        Some((best, variants))
    }

    /// Cogging is one effect of several orders: adds them while each predicts better.
    fn more_orders(&self, base: &Fit, first: Fit, effect: &'static Effect) -> Fit {
        let fitter = self.fitter();
        let mut best = first;
        if 1.0 - (best.heldout_sse() / base.heldout_sse()).sqrt() < 0.5 * MIN_GAIN {
            return best;
        }
        while best.active.len() < MAX_ENTRIES {
            let raw: Vec<f64> = best.residual.iter().zip(&self.weights).map(|(r, w)| r / w).collect();
            let orders = orders_left(self.problem, &raw, &self.excitation);
            let size = 0.02 * self.excitation.torque_rms;
            let entry = orders.first().map(|&order| {
                let values = vec![order, size, size];
                let ranges = effect.ranges(values.len(), &self.problem.nominal, &self.excitation);
                Active { effect, values, ranges }
            });
            let Some(entry) = entry.filter(|entry| !duplicate(&best.active, entry)) else { break };
            let known = fitter.base(&best);
            let more = fitter.fit_on(&[best.active.as_slice(), &[entry]].concat(), ITERATIONS, &known);
            let gain = 1.0 - (more.heldout_sse() / best.heldout_sse()).sqrt();
            if gain < MIN_GAIN {
                break;
            }
            best = more;
        }
        best
    }

    /// Every effect that fits on top of a model, best held-out first.
    fn round(&mut self, base: &Fit) -> Vec<Trial> {
        let open: Vec<&'static Effect> = self
            .vocabulary
            .iter()
            .copied()
            .filter(|effect| {
                !base.active.iter().any(|entry| conflicts(entry.effect, effect)) && !full(&base.active, effect)
            })
            .collect();
        let fitted: Vec<(&'static Effect, Fit, usize)> = open
            .par_iter()
            .filter_map(|&effect| {
                let (fit, variants) = self.attempt(base, effect)?;
                let fit = if effect.id == "cogging" { self.more_orders(base, fit, effect) } else { fit };
                Some((effect, fit, variants))
            })
            .collect();
        self.variants += fitted.iter().map(|(_, _, variants)| variants).sum::<usize>();
        let variants = self.variants.max(1);
        let mut trials: Vec<Trial> =
            fitted.into_iter().map(|(effect, fit, _)| self.judge(base, effect, fit, variants)).collect();
        trials.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        trials
    }

    fn judge(&self, base: &Fit, effect: &'static Effect, fit: Fit, variants: usize) -> Trial {
        let pulse = effect.id == PULSE;
        // Every start and duration was a trial.
        let variants = if pulse { variants + spans(self.problem) } else { variants };
        let p_value = (p_value(self.problem, base, &fit) * variants as f64).min(1.0);
        let (before, after, t) = if pulse {
            // One event cannot be predicted from the other blocks; its own recording is its evidence.
            let stands_out = stands_out(self.problem, base, &fit);
            (base.sse, fit.sse, if stands_out { f64::INFINITY } else { 0.0 })
        } else {
            (base.heldout_sse(), fit.heldout_sse(), paired_t(base, &fit).max(relative_t(base, &fit)))
        };
        Trial { effect, fit, gain: 1.0 - (after / before.max(1e-300)).sqrt(), p_value, t }
    }

    /// Among accepted trials, the simplest that predicts not significantly worse than the best. An event explains one
    /// place: it comes after everything that explains several.
    fn choose<'t>(&self, trials: &'t [Trial]) -> Option<&'t Trial> {
        let accepted = || trials.iter().filter(|trial| trial.accepted());
        let best = accepted().find(|trial| trial.effect.id != PULSE).or_else(|| accepted().next())?;
        if best.effect.id == PULSE {
            return Some(best);
        }
        let rivals = trials.iter().filter(|trial| {
            trial.accepted() && trial.fit.freedom() < best.fit.freedom() && !worse(&trial.fit, &best.fit)
        });
        rivals.min_by_key(|trial| trial.fit.freedom()).or(Some(best))
    }

    /// Runs the search from a model; without one from the nominal machine.
    pub fn run(mut self, start: &[Active]) -> Outcome {
        if !start.is_empty() {
            self.weigh(start);
        }
        let mut fit = self.fitter().fit(start, ITERATIONS);
        fit = self.backward(fit);
        let mut seen: Vec<Trial> = Vec::new();
        // A step that the next one takes back would repeat for ever.
        for _ in 0..=MAX_EFFECTS {
            let trials = self.round(&fit);
            let chosen = self.choose(&trials).cloned();
            merge(&mut seen, &trials);
            let Some(chosen) = chosen else { break };
            let before = fit.active.len();
            fit = self.fitter().fit(&chosen.fit.active, ITERATIONS);
            fit = self.exchange(fit, &seen);
            fit = self.backward(fit);
            let stays = fit.active.len() <= before;
            self.weigh(&fit.active);
            fit = self.fitter().fit(&fit.active, ITERATIONS);
            if stays {
                break;
            }
        }
        fit = self.backward(fit);
        let nominal = self.fitter().fit(&[], 0);
        seen.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        Outcome {
            fit,
            nominal,
            weights: self.weights,
            trials: seen,
            excitation: self.excitation,
            variants: self.variants,
        }
    }

    /// Replaces one member by another effect while that predicts better.
    fn exchange(&mut self, fit: Fit, seen: &[Trial]) -> Fit {
        if fit.active.len() < 2 {
            return fit;
        }
        let mut best = fit;
        for _ in 0..1 {
            let mut better: Option<Fit> = None;
            for index in 0..best.active.len() {
                let mut rest = best.active.clone();
                let out = rest.remove(index);
                let base = self.fitter().fit(&rest, ITERATIONS);
                let open: Vec<&'static Effect> = seen
                    .iter()
                    .filter(|trial| trial.gain > MIN_GAIN)
                    .map(|trial| trial.effect)
                    .filter(|effect| effect.id != out.effect.id)
                    .filter(|effect| !rest.iter().any(|entry| conflicts(entry.effect, effect)))
                    .take(4)
                    .collect();
                let fits: Vec<Fit> =
                    open.par_iter().filter_map(|&effect| self.attempt(&base, effect)).map(|(fit, _)| fit).collect();
                for fit in fits {
                    let top = better.as_ref().unwrap_or(&best);
                    let gain = 1.0 - (fit.heldout_sse() / top.heldout_sse()).sqrt();
                    if gain > 0.01 && worse(top, &fit) {
                        better = Some(fit);
                    }
                }
            }
            match better {
                Some(fit) => best = fit,
                None => break,
            }
        }
        best
    }

    /// Drops members that the held-out blocks do not miss.
    fn backward(&self, mut fit: Fit) -> Fit {
        loop {
            let without = |index: usize| {
                let mut rest = fit.active.clone();
                rest.remove(index);
                self.fitter().fit(&rest, ITERATIONS)
            };
            let removable = (0..fit.active.len())
                .filter(|&index| fit.active[index].effect.id != PULSE)
                .map(without)
                .map(|smaller| (1.0 - (fit.heldout_sse() / smaller.heldout_sse().max(1e-300)).sqrt(), smaller))
                .filter(|(gain, _)| *gain < MIN_GAIN)
                .min_by(|a, b| a.0.total_cmp(&b.0));
            match removable {
                Some((_, smaller)) => fit = smaller,
                None => return fit,
            }
        }
    }
}

fn merge(seen: &mut Vec<Trial>, trials: &[Trial]) {
    for trial in trials {
        match seen.iter_mut().find(|old| old.effect.id == trial.effect.id) {
            Some(old) => *old = trial.clone(),
            None => seen.push(trial.clone()),
        }
    }
}

/// Whether `fit` predicts the blocks significantly worse than `best`: paired over blocks, and by more than a hair.
pub fn worse(fit: &Fit, best: &Fit) -> bool {
    paired_t(fit, best) > 2.0 && fit.heldout_sse() - best.heldout_sse() > 0.01 * best.heldout_sse()
}

/// t of the fall of the held-out squares from one fit to another, paired over blocks.
fn paired_t(from: &Fit, to: &Fit) -> f64 {
    let pairs = from.heldout.iter().zip(&to.heldout).filter(|(a, b)| **a > 0.0 || **b > 0.0);
    let changes: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
    t_of_mean(&changes)
}

fn t_of_mean(changes: &[f64]) -> f64 {
    let count = changes.len() as f64;
    if count < 2.0 {
        return 0.0;
    }
    let mean = changes.iter().sum::<f64>() / count;
    let variance = changes.iter().map(|c| (c - mean) * (c - mean)).sum::<f64>() / (count - 1.0);
    mean / (variance / count).sqrt().max(1e-300)
}

/// The same with each block's change relative to its size: an effect that shows in a few strong blocks is as certain as
/// one that shows a little in all.
fn relative_t(from: &Fit, to: &Fit) -> f64 {
    let relative = |(a, b): (&f64, &f64)| (a + b > 0.0).then(|| (a - b) / (a + b));
    let changes: Vec<f64> = from.heldout.iter().zip(&to.heldout).filter_map(relative).collect();
    t_of_mean(&changes)
}

/// F-test of an improvement, its freedom reduced by the correlation of neighbouring residuals (Newey-West, Bartlett).
fn p_value(problem: &Problem, base: &Fit, fit: &Fit) -> f64 {
    let added = fit.freedom().saturating_sub(base.freedom()).max(1) as f64;
    let inflation = inflation(problem, fit);
    let count = (fit.residual.len() as f64 / inflation - fit.freedom() as f64).max(1.0);
    let numerator = (base.sse - fit.sse).max(0.0) / added / inflation;
    let statistic = numerator / (fit.sse / fit.residual.len() as f64);
    FisherSnedecor::new(added, count).map_or(1.0, |f| f.sf(statistic).max(1e-300))
}

/// How many neighbouring equations count as one: one plus twice the tapered autocorrelations over 0.1 s.
fn inflation(problem: &Problem, fit: &Fit) -> f64 {
    let reach_s = 0.1;
    let equations = &problem.equations;
    let (mut cross, mut squares) = (0.0, 0.0);
    for i in 0..equations.len() {
        squares += fit.residual[i] * fit.residual[i];
        for j in i + 1..equations.len() {
            let apart_s = equations[j].row.centre_s - equations[i].row.centre_s;
            if equations[j].recording != equations[i].recording || apart_s > reach_s {
                break;
            }
            cross += (1.0 - apart_s / reach_s) * fit.residual[i] * fit.residual[j];
        }
    }
    (1.0 + 2.0 * cross / squares.max(1e-300)).max(1.0)
}
