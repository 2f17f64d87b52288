//! Forward, exchange and backward steps over the vocabulary, judged by blocks left out.

use rayon::prelude::*;

use super::candidates::{excitation, spans, stands_out};
use super::fit::{Fit, Fitter};
use super::judge::{MIN_GAIN, MIN_T, Trial, fall_t, p_value, worse};
use super::noise::weights;
use super::problem::{Active, Problem};
use crate::effects::{Effect, Excitation};
use crate::progress::Progress;

/// Effects of a combination at most, orders of cogging counted as one.
const MAX_EFFECTS: usize = 4;
/// Entries at most: several orders of cogging are one effect.
pub(super) const MAX_ENTRIES: usize = 7;
/// Iterations of a fit.
pub(super) const ITERATIONS: usize = 12;

/// An effect that alone predicts this much better, though not in enough blocks, may be half of a pair;
const HALF: f64 = 0.1;
/// so many of them are tried.
const COUPLED: usize = 3;

/// The scale of the drive stands for every other torque together, and so in the way of each: it comes last among equals.
pub(crate) const SCALE: &str = "torque_gain";

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
    /// What the first step accepted, best held-out first.
    pub first_step: Vec<Trial>,
    /// Sizes and candidates of the last step.
    pub excitation: Excitation,
    /// Number of variants fitted or glimpsed.
    pub variants: usize,
}

/// Effects that change the same numbers cannot stand together.
pub(super) fn conflicts(a: &Effect, b: &Effect) -> bool {
    const GROUPS: [&[&str]; 3] = [
        &["field_lag", "field_lag_asymmetry"],
        &[
            "viscosity_dead_time",
            "viscosity_lag",
            "field_dead_time",
            "field_lag",
            "field_lag_asymmetry",
            "field_slew_limit",
            "er_preyield",
        ],
        &["compliance", "backlash"],
    ];
    if a.id == b.id {
        return a.id != "cogging" && !a.is_event();
    }
    let viscosity = |e: &Effect| e.id.starts_with("viscosity");
    GROUPS
        .iter()
        .enumerate()
        .any(|(group, ids)| ids.contains(&a.id) && ids.contains(&b.id) && (group != 1 || viscosity(a) || viscosity(b)))
}

pub(super) fn full(active: &[Active], effect: &Effect) -> bool {
    let mut ids: Vec<&str> = active.iter().map(|entry| entry.effect.id).chain([effect.id]).collect();
    ids.sort_unstable();
    ids.dedup();
    ids.len() > MAX_EFFECTS || active.len() >= MAX_ENTRIES
}

/// Searches a vocabulary over the recordings of a problem.
#[derive(Debug)]
pub struct Search<'a> {
    pub(super) problem: &'a Problem,
    vocabulary: &'a [&'static Effect],
    linear: bool,
    pub(super) weights: Vec<f64>,
    pub(super) excitation: Excitation,
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

    /// The search as an outcome left it.
    pub(super) fn resumed(problem: &'a Problem, outcome: &Outcome) -> Self {
        let (weights, excitation) = (outcome.weights.clone(), outcome.excitation.clone());
        Self { problem, vocabulary: &[], linear: excitation.linear, weights, excitation, variants: 0 }
    }

    /// New weights and candidates from what is left by a model.
    fn weigh(&mut self, active: &[Active]) {
        let machine = self.problem.machine(active);
        let raw = self.problem.residual(&self.problem.parts(&machine, None));
        self.excitation = excitation(self.problem, &machine, &raw, self.linear);
        self.weights = weights(self.problem, &raw);
    }

    pub(super) fn fitter(&self) -> Fitter<'_> {
        Fitter { problem: self.problem, weights: &self.weights }
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
        let known = self.fitter().base(base);
        let progress = Progress::new(&format!("effects on top of {}", base.active.len()), open.len() as u64);
        let fitted: Vec<(&'static Effect, Fit, usize)> = open
            .par_iter()
            .inspect(|_| progress.advance(1))
            .filter_map(|&effect| {
                let (fit, variants) = self.attempt(base, &known, effect)?;
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
        let event = effect.is_event();
        // Every start and duration was a trial.
        let variants = if event { variants + spans(self.problem) } else { variants };
        let p_value = (p_value(self.problem, base, &fit) * variants as f64).min(1.0);
        let (before, after, t) = if event {
            // One event cannot be predicted from the other blocks; its own recording is its evidence.
            let stands_out = stands_out(self.problem, base, &fit);
            (base.sse, fit.sse, if stands_out { f64::INFINITY } else { 0.0 })
        } else {
            (base.heldout_sse(), fit.heldout_sse(), fall_t(&base.heldout, &fit.heldout))
        };
        Trial { effect, fit, gain: 1.0 - (after / before.max(1e-300)).sqrt(), p_value, t }
    }

    /// Among accepted trials, the simplest that predicts not significantly worse than the best; the scale of the drive last
    /// among equals. An event explains one place: it comes after
    /// everything that explains several.
    fn choose<'t>(&self, trials: &'t [Trial]) -> Option<&'t Trial> {
        let accepted = || trials.iter().filter(|trial| trial.accepted());
        let best = accepted().find(|trial| !trial.effect.is_event()).or_else(|| accepted().next())?;
        if best.effect.is_event() {
            return Some(best);
        }
        let cost = |trial: &Trial| (trial.fit.freedom(), trial.effect.id == SCALE);
        let rivals = accepted().filter(|trial| cost(trial) < cost(best) && !worse(&trial.fit, &best.fit));
        rivals.min_by_key(|trial| cost(trial)).or(Some(best))
    }

    /// What the first step from the nominal machine accepts, best held-out first.
    pub fn first_step(mut self) -> Vec<Trial> {
        let base = self.fitter().fit(&[], 0);
        accepted(&self.round(&base))
    }

    /// Runs the search from a model; without one from the nominal machine.
    pub fn run(mut self, start: &[Active]) -> Outcome {
        if !start.is_empty() {
            self.weigh(start);
        }
        let mut fit = self.backward(self.fitter().fit(start, ITERATIONS));
        let mut seen: Vec<Trial> = Vec::new();
        let mut first_step = None;
        for _ in 0..=MAX_EFFECTS {
            if self.problem.budget.check() {
                break;
            }
            let before = fit.active.len();
            let next = self.forward(&fit, &mut seen);
            first_step.get_or_insert_with(|| accepted(&seen));
            let Some(next) = next else { break };
            fit = next;
            // A step that the next one takes back would repeat for ever.
            if fit.active.len() <= before {
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
            first_step: first_step.unwrap_or_default(),
            excitation: self.excitation,
            variants: self.variants,
        }
    }

    /// One effect more, members exchanged and dropped, under new weights; none where nothing more is accepted.
    fn forward(&mut self, base: &Fit, seen: &mut Vec<Trial>) -> Option<Fit> {
        let trials = self.round(base);
        let chosen = self.choose(&trials).cloned().or_else(|| self.couple(base, &trials));
        merge(seen, &trials);
        let fit = self.fitter().fit(&chosen?.fit.active, ITERATIONS);
        let fit = self.backward(self.exchange(fit, seen));
        self.weigh(&fit.active);
        Some(self.fitter().fit(&fit.active, ITERATIONS))
    }

    /// Two effects at once, where neither is accepted alone: what one mends in one direction it may spoil in the other.
    fn couple(&mut self, base: &Fit, trials: &[Trial]) -> Option<Trial> {
        let strong = |trial: &&Trial| trial.gain >= HALF && !trial.at_bound();
        let halves = trials.iter().filter(strong).filter(|trial| !trial.effect.is_event()).take(COUPLED);
        let halves = halves.take_while(|_| !self.problem.budget.check());
        let pairs: Vec<Trial> = halves.flat_map(|half| self.round(&half.fit)).collect();
        let everywhere = |trial: &Trial| fall_t(&base.heldout, &trial.fit.heldout) >= MIN_T;
        let accepted =
            pairs.into_iter().filter(|trial| !trial.effect.is_event() && trial.accepted() && everywhere(trial));
        accepted.min_by(|a, b| a.fit.heldout_sse().total_cmp(&b.fit.heldout_sse()))
    }

    /// Replaces one member by another effect where that predicts better, or as well with fewer others beside it.
    fn exchange(&self, fit: Fit, seen: &[Trial]) -> Fit {
        if fit.active.len() < 2 {
            return fit;
        }
        let mut best = fit.clone();
        for candidate in (0..fit.active.len()).flat_map(|index| self.without_and_with(&fit, index, seen)) {
            let gain = 1.0 - (candidate.heldout_sse() / best.heldout_sse()).sqrt();
            if gain > 0.01 && worse(&best, &candidate) {
                best = candidate;
            } else if candidate.active.last().is_some_and(|entry| entry.effect.id != SCALE) && !worse(&candidate, &best)
            {
                let smaller = self.backward(candidate);
                if smaller.active.len() < best.active.len() && !worse(&smaller, &best) {
                    best = smaller;
                }
            }
        }
        best
    }

    /// Fits with one member left out and each of the best other effects in its place, where that is not at a bound.
    fn without_and_with(&self, fit: &Fit, index: usize, seen: &[Trial]) -> Vec<Fit> {
        let mut rest = fit.active.clone();
        let out = rest.remove(index);
        let base = self.fitter().fit(&rest, ITERATIONS);
        let known = self.fitter().base(&base);
        let open: Vec<&'static Effect> = seen
            .iter()
            .filter(|trial| trial.gain > MIN_GAIN)
            .map(|trial| trial.effect)
            .filter(|effect| effect.id != out.effect.id)
            .filter(|effect| !rest.iter().any(|entry| conflicts(entry.effect, effect)))
            .take(4)
            .collect();
        let fits = open.par_iter().filter_map(|&effect| Some(self.attempt(&base, &known, effect)?.0));
        fits.filter(|fit| !fit.at_bound()).collect()
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
                .filter(|&index| !fit.active[index].effect.is_event())
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

fn accepted(trials: &[Trial]) -> Vec<Trial> {
    trials.iter().filter(|trial| trial.accepted()).cloned().collect()
}

fn merge(seen: &mut Vec<Trial>, trials: &[Trial]) {
    for trial in trials {
        match seen.iter_mut().find(|old| old.effect.id == trial.effect.id) {
            Some(old) => *old = trial.clone(),
            None => seen.push(trial.clone()),
        }
    }
}
