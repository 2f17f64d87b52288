//! Every candidate at once: columns of one regression with the whitened residual on the left.

mod orders;
mod pushes;
mod seek;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::effects::{Columns, Effect, Excitation};
use crate::hypothesis::{Entry, Hypothesis, Kept, Refitted, columns, evaluate, kept, over_excerpts, product};
use crate::likelihood::Noise;
use crate::physics::Physics;
use crate::problem::Problem;

pub(crate) use pushes::by_chance;
use seek::seek;

/// A start of an effect with what it promises.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The effect at start values that the regression has set.
    pub entry: Entry,
    /// The start itself.
    pub from: Vec<f64>,
    /// Log-likelihood it brings on the recordings to fit: in the linear model, or as it starts where no column tells.
    pub gain: f64,
    /// Among how many variants of this effect it was found.
    pub tries: f64,
}

impl Candidate {
    /// Found among one.
    fn new(effect: &'static Effect, from: Vec<f64>, values: Vec<f64>, gain: f64) -> Self {
        Self { entry: Entry { effect, values }, from, gain, tries: 1.0 }
    }
}

/// Share of a hypothesis's torque noise that columns are scored under. Where physics is missing, its noise stands in for that, by ten times in
/// variance on tuning seed 5818, and what it stands in for no column shows: a true order came behind fourteen others there, and is the first
/// under a tenth and under a hundredth.
const SHARE_OF_NOISE: f64 = 0.1;

/// Scores every start of every effect beside a hypothesis, along its own pass under less noise; best first. None where that pass is not
/// finite.
pub(crate) fn score(problem: &Problem, at: &Refitted, vocabulary: &[&'static Effect]) -> Option<Vec<Candidate>> {
    let hypothesis = &at.hypothesis;
    // Where the motion is given all noise is one, and less of it only leaves more to Huber.
    let share = if problem.motions.is_empty() { SHARE_OF_NOISE } else { 1.0 };
    let noise: Vec<Noise> = at.noise.iter().map(|noise| noise.with_torque_share(share)).collect();
    let path = &kept(problem, &hypothesis.physics(&problem.nominal), &noise, problem.fitted)?;
    let own: Vec<Vec<Vec<f64>>> = columns(problem, hypothesis, path).into_iter().flatten().collect();
    let base = Base::new(problem, at, path, own);
    let excitation = seek(problem, path);
    let physics = &path.physics;
    let starts: Vec<(&'static Effect, Vec<f64>)> = vocabulary
        .iter()
        .filter(|effect| (effect.applies)(&problem.nominal, &excitation))
        .filter(|effect| !hypothesis.entries.iter().any(|entry| entry.indistinct(problem, effect)))
        .filter(|effect| effect.repeats || hypothesis.entries.iter().all(|entry| entry.effect != **effect))
        .flat_map(|effect| (effect.starts)(physics, &excitation).into_iter().map(|values| (*effect, values)))
        .filter(|(effect, values)| !overlaps(hypothesis, effect, values))
        .collect();
    let mut all: Vec<Candidate> = starts
        .into_par_iter()
        .filter_map(|(effect, values)| candidate(problem, hypothesis, path, &base, &excitation, effect, values))
        .collect();
    let of = |effect: &Effect| all.iter().filter(|candidate| candidate.entry.effect == effect).count().max(1) as f64;
    let tries: Vec<f64> =
        all.iter().map(|one| (one.entry.effect.looked_at)(&excitation).max(of(one.entry.effect))).collect();
    for (candidate, tries) in all.iter_mut().zip(tries) {
        candidate.tries = tries;
    }
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    Some(all)
}

/// Whether it would happen while something of its kind happens already: the shape of one event is no second one.
fn overlaps(hypothesis: &Hypothesis, effect: &Effect, values: &[f64]) -> bool {
    let Some((recording, from_s, to_s)) = (effect.span)(values) else { return false };
    let spans = hypothesis.entries.iter().filter_map(|entry| (entry.effect.span)(&entry.values));
    spans.into_iter().any(|(other, start_s, end_s)| other == recording && start_s < to_s && from_s < end_s)
}

/// The residual, its weights, and the columns of the hypothesis itself.
struct Base<'a> {
    /// The noise of the hypothesis.
    noise: &'a [Noise],
    /// As [`as_it_starts`] has it, under that noise.
    as_it_is: Option<f64>,
    residual: Vec<f64>,
    weight: Vec<f64>,
    /// Mean square of the residual, at least 1: a gain is of the log-likelihood of residuals that spread so much.
    scale: f64,
    own: Vec<Vec<f64>>,
    /// Of the own columns.
    information: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl<'a> Base<'a> {
    fn new(problem: &Problem, at: &'a Refitted, path: &Kept, own: Vec<Vec<Vec<f64>>>) -> Self {
        let as_it_is = as_it_starts(problem, &path.physics, &at.noise);
        let (residual, weight) = path.weighted();
        let squares: f64 = weight.iter().zip(&residual).map(|(weight, residual)| weight * residual * residual).sum();
        let scale = (squares / weight.iter().sum::<f64>()).max(1.0);
        let own: Vec<Vec<f64>> = own.into_iter().map(|column| column.concat()).collect();
        let many = own.len();
        let (information, gradient) = (DMatrix::zeros(many, many), DVector::zeros(many));
        let mut base = Self { noise: &at.noise, as_it_is, residual, weight, scale, own, information, gradient };
        for i in 0..many {
            base.gradient[i] = -base.dot(&base.own[i], &base.residual);
            for j in 0..=i {
                let product = base.dot(&base.own[i], &base.own[j]);
                (base.information[(i, j)], base.information[(j, i)]) = (product, product);
            }
        }
        base
    }

    fn dot(&self, one: &[f64], other: &[f64]) -> f64 {
        product(&self.weight, one, other)
    }

    /// Coefficients of new columns beside the own ones, and the log-likelihood they bring beyond what the own ones still can.
    fn regress(&self, new: &[Vec<f64>]) -> Option<(Vec<f64>, f64)> {
        let (many, more) = (self.own.len(), new.len());
        let mut cross = DMatrix::zeros(many, more);
        let mut inside = DMatrix::zeros(more, more);
        let mut gradient = DVector::zeros(more);
        for (i, column) in new.iter().enumerate() {
            gradient[i] = -self.dot(column, &self.residual);
            for (j, own) in self.own.iter().enumerate() {
                cross[(j, i)] = self.dot(own, column);
            }
            for j in 0..=i {
                let product = self.dot(column, &new[j]);
                (inside[(i, j)], inside[(j, i)]) = (product, product);
            }
        }
        let before: Vec<f64> = (0..more).map(|i| inside[(i, i)]).collect();
        if many > 0 {
            let mut own = self.information.clone();
            for i in 0..many {
                own[(i, i)] *= 1.0 + 1e-9;
            }
            let own = own.cholesky()?;
            gradient -= cross.transpose() * own.solve(&self.gradient);
            inside -= cross.transpose() * own.solve(&cross);
        }
        // A column of which the own ones leave less than this is one of them.
        for i in 0..more {
            if inside[(i, i)] <= 1e-6 * before[i] {
                return None;
            }
            inside[(i, i)] *= 1.0 + 1e-9;
        }
        let coefficients = inside.cholesky()?.solve(&gradient);
        let gain = 0.5 * coefficients.dot(&gradient) / self.scale;
        gain.is_finite().then(|| (coefficients.iter().copied().collect(), gain))
    }
}

/// The log-likelihood that a machine starts a refit from: of the excerpts, scaled to all rows, or where the motion is given, which costs
/// little, of all. None for a machine the plant refuses or a pass that is not finite.
pub(crate) fn as_it_starts(problem: &Problem, physics: &Physics, noise: &[Noise]) -> Option<f64> {
    if problem.motions.is_empty() {
        return over_excerpts(problem, physics, noise);
    }
    Some(evaluate(problem, physics, noise, 0..problem.fitted)?.fitted(problem))
}

fn candidate(
    problem: &Problem,
    hypothesis: &Hypothesis,
    path: &Kept,
    base: &Base<'_>,
    excitation: &Excitation,
    effect: &'static Effect,
    values: Vec<f64>,
) -> Option<Candidate> {
    // No column tells what changes samples and no motion, or what a memory makes of a motion.
    if effect.changes_samples_only() || effect.remembers {
        let other = hypothesis.with(effect, values.clone());
        let other = other.physics(&problem.nominal);
        let gain = as_it_starts(problem, &other, base.noise)? - base.as_it_is?;
        return Some(Candidate::new(effect, values.clone(), values, gain));
    }
    let response = |values: &[f64]| {
        let other = hypothesis.with(effect, values.to_vec()).physics(&problem.nominal);
        let column = path.response(problem, &other)?.concat();
        column.iter().any(|value| *value != 0.0).then_some(column)
    };
    match effect.columns {
        Columns::Whole => {
            let (coefficients, gain) = base.regress(&[response(&values)?])?;
            // Towards less than nothing is no such effect; how far its step reaches only a refit can tell.
            (coefficients[0] > 0.0).then(|| Candidate::new(effect, values.clone(), values, gain))
        }
        Columns::Scaled(index) => {
            let (coefficients, gain) = base.regress(&[response(&values)?])?;
            let from = values.clone();
            let mut values = values;
            let range = effect.ranges(values.len(), &problem.nominal, excitation)[index];
            values[index] = (values[index] * coefficients[0]).max(range.low).min(range.high);
            Some(Candidate::new(effect, from, values, gain))
        }
        Columns::Each => {
            let ranges = effect.ranges(values.len(), &problem.nominal, excitation);
            let free = (0..values.len()).filter(|&index| effect.parameter(index).free);
            let (mut places, mut new) = (Vec::new(), Vec::new());
            for index in free {
                let mut tried = values.clone();
                tried[index] += ranges[index].scale;
                if let Some(column) = response(&tried) {
                    places.push(index);
                    new.push(column);
                }
            }
            let (coefficients, gain) = base.regress(&new)?;
            let from = values.clone();
            let mut values = values;
            for (&place, coefficient) in places.iter().zip(coefficients) {
                let range = ranges[place];
                values[place] = (values[place] + coefficient * range.scale).max(range.low).min(range.high);
            }
            Some(Candidate::new(effect, from, values, gain))
        }
    }
}
