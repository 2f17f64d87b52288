//! Forward, exchange and backward steps over the vocabulary, judged by blocks left out.

use rayon::prelude::*;

use super::candidates::{excitation, orders_left, spans, stands_out};
use super::fit::{Base, Fit, Fitter};
use super::judge::{MIN_GAIN, Trial, p_value, paired_t, relative_t, worse};
use super::noise::weights;
use super::problem::{Active, Problem};
use crate::effects::{Effect, Excitation};
use crate::progress::Progress;

/// Effects of a combination at most, orders of cogging counted as one.
const MAX_EFFECTS: usize = 4;
/// Entries at most: several orders of cogging are one effect.
const MAX_ENTRIES: usize = 7;
/// Start values that are fitted to the end.
const FINALISTS: usize = 2;
/// A start whose first step leaves more than this share of the squares is not worth a fit to the end.
const HOPELESS: f64 = 0.985;
/// Evaluations of a search without derivatives.
const FEELS: usize = 120;
/// Iterations of a fit.
pub(super) const ITERATIONS: usize = 12;

/// The one effect that is an event.
const PULSE: &str = "disturbance_pulse";

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

pub(super) fn full(active: &[Active], effect: &Effect) -> bool {
    let mut ids: Vec<&str> = active.iter().map(|entry| entry.effect.id).chain([effect.id]).collect();
    ids.sort_unstable();
    ids.dedup();
    ids.len() > MAX_EFFECTS || active.len() >= MAX_ENTRIES
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

    /// The search as an outcome left it.
    pub(super) fn resumed(problem: &'a Problem, outcome: &Outcome) -> Self {
        let (weights, excitation) = (outcome.weights.clone(), outcome.excitation.clone());
        Self { problem, vocabulary: &[], linear: excitation.linear, weights, excitation, variants: 0 }
    }

    /// The problem that is searched.
    pub(super) fn problem(&self) -> &'a Problem {
        self.problem
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

    /// The best values of an effect on top of a model.
    pub(super) fn attempt(&self, base: &Fit, known: &Base, effect: &'static Effect) -> Option<(Fit, usize)> {
        let machine = self.problem.machine(&base.active);
        if !(effect.applies)(&machine, &self.excitation) {
            return None;
        }
        let fitter = self.fitter();
        let with = |entry: &Active| [base.active.as_slice(), std::slice::from_ref(entry)].concat();
        let mut glimpsed: Vec<(f64, Active)> = (effect.starts)(&machine, &self.excitation)
            .into_iter()
            .map(|values| {
                let ranges = effect.ranges(values.len(), &self.problem.nominal, &self.excitation);
                Active { effect, values, ranges }
            })
            .filter(|entry| !duplicate(&base.active, entry))
            .filter_map(|entry| {
                let (sse, mut reached) = if kinked(effect) {
                    fitter.feel(&with(&entry), known, 1)
                } else {
                    fitter.glimpse(&with(&entry), known)
                };
                reached.pop().map(|entry| (sse, entry))
            })
            .collect();
        let variants = glimpsed.len();
        glimpsed.sort_by(|a, b| a.0.total_cmp(&b.0));
        if kinked(effect) {
            // Where nothing on the grid is better than none of it, the rest is not worth the time.
            glimpsed.truncate(if glimpsed.first().is_some_and(|best| best.0 < base.sse) { FINALISTS } else { 1 });
            let promising = glimpsed.iter_mut().filter(|glimpsed| glimpsed.0 < base.sse);
            promising.for_each(|glimpsed| feel_on(&fitter, base, known, glimpsed));
        }
        let (finalists, iterations) = match glimpsed.first() {
            Some((sse, _)) if *sse > HOPELESS * base.sse => (1, 2),
            _ => (FINALISTS, ITERATIONS),
        };
        let finalists = glimpsed.iter().take(finalists);
        let fits = finalists.map(|(_, entry)| fitter.fit_on(&with(entry), iterations, known));
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

    /// Among accepted trials, the simplest that predicts not significantly worse than the best; the scale of the drive last
    /// among equals, because it stands for every other torque together. An event explains one place: it comes after
    /// everything that explains several.
    fn choose<'t>(&self, trials: &'t [Trial]) -> Option<&'t Trial> {
        let accepted = || trials.iter().filter(|trial| trial.accepted());
        let best = accepted().find(|trial| trial.effect.id != PULSE).or_else(|| accepted().next())?;
        if best.effect.id == PULSE {
            return Some(best);
        }
        let cost = |trial: &Trial| (trial.fit.freedom(), trial.effect.id == "torque_gain");
        let rivals = accepted().filter(|trial| cost(trial) < cost(best) && !worse(&trial.fit, &best.fit));
        rivals.min_by_key(|trial| cost(trial)).or(Some(best))
    }

    /// What the first step from the nominal machine accepts, best held-out first.
    pub fn first_step(mut self) -> Vec<Trial> {
        let base = self.fitter().fit(&[], 0);
        let mut trials = self.round(&base);
        trials.retain(Trial::accepted);
        trials
    }

    /// Runs the search from a model; without one from the nominal machine.
    pub fn run(mut self, start: &[Active]) -> Outcome {
        if !start.is_empty() {
            self.weigh(start);
        }
        let mut fit = self.backward(self.fitter().fit(start, ITERATIONS));
        let mut seen: Vec<Trial> = Vec::new();
        for _ in 0..=MAX_EFFECTS {
            let before = fit.active.len();
            let Some(next) = self.forward(&fit, &mut seen) else { break };
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
            excitation: self.excitation,
            variants: self.variants,
        }
    }

    /// One effect more, members exchanged and dropped, under new weights; none where nothing more is accepted.
    fn forward(&mut self, base: &Fit, seen: &mut Vec<Trial>) -> Option<Fit> {
        let trials = self.round(base);
        let chosen = self.choose(&trials).cloned();
        merge(seen, &trials);
        let fit = self.fitter().fit(&chosen?.fit.active, ITERATIONS);
        let fit = self.backward(self.exchange(fit, seen));
        self.weigh(&fit.active);
        Some(self.fitter().fit(&fit.active, ITERATIONS))
    }

    /// Replaces one member by another effect where that predicts better.
    fn exchange(&self, fit: Fit, seen: &[Trial]) -> Fit {
        if fit.active.len() < 2 {
            return fit;
        }
        let mut best = fit.clone();
        for candidate in (0..fit.active.len()).flat_map(|index| self.without_and_with(&fit, index, seen)) {
            let gain = 1.0 - (candidate.heldout_sse() / best.heldout_sse()).sqrt();
            if gain > 0.01 && worse(&best, &candidate) {
                best = candidate;
            }
        }
        best
    }

    /// Fits with one member left out and each of the best other effects in its place.
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
        open.par_iter().filter_map(|&effect| self.attempt(&base, &known, effect)).map(|(fit, _)| fit).collect()
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

/// Goes on from a start without derivatives, with a scan between two passes.
fn feel_on(fitter: &Fitter<'_>, base: &Fit, known: &Base, (sse, entry): &mut (f64, Active)) {
    let start = [base.active.as_slice(), std::slice::from_ref(entry)].concat();
    let (_, felt) = fitter.feel(&start, known, FEELS);
    let (_, scanned) = fitter.scan(&felt, known);
    let (low, mut reached) = fitter.feel(&scanned, known, FEELS);
    if let Some(found) = reached.pop().filter(|_| low < *sse) {
        (*sse, *entry) = (low, found);
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
