//! Values of a hypothesis by maximum likelihood: Levenberg-Marquardt on the linearised pass.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::Hypothesis;
use super::along::{FINEST, FINEST_OF_ROUGH, searched};
use super::differences::by_differences;
use super::evaluate::{Evaluation, Kept, KeptRecording, evaluate, kept};
use super::noise_fit::{noise_of, noise_on_all_rows};
use crate::likelihood::filter::HUBER;
use crate::likelihood::{Innovations, Noise};
use crate::physics::Physics;
use crate::problem::Problem;

/// A hypothesis at its optimum.
#[derive(Debug, Clone)]
pub struct Refitted {
    /// With the fitted values.
    pub hypothesis: Hypothesis,
    /// The noise of each recording that goes with it.
    pub noise: Vec<Noise>,
    /// The recordings to fit under both, and those held out once they have been looked at.
    pub evaluation: Evaluation,
    /// Log-likelihood of the recordings to fit.
    pub log_likelihood: f64,
}

impl Refitted {
    /// With the recordings that are held out, each under the noise of its own.
    pub fn over_all(self, problem: &Problem) -> Option<Self> {
        let (looked_at, all) = (self.evaluation.blocks.len(), problem.recordings.len());
        if looked_at == all {
            return Some(self);
        }
        let physics = self.hypothesis.physics(&problem.nominal);
        let mut found = self;
        let held_out = evaluate(problem, &physics, &found.noise, looked_at..all)?;
        found.evaluation.blocks.extend(held_out.blocks);
        found.evaluation.innovations.extend(held_out.innovations);
        for estimate in [on_excerpts, noise_on_all_rows] {
            let noise = estimate(problem, &physics, &found.noise, looked_at..all);
            found.take_likelier_noise(problem, &physics, &noise, looked_at..all)?;
        }
        Some(found)
    }

    /// Goes over to another noise of some recordings, for each as far as that makes it likelier: estimated on an excerpt, it must hold on the
    /// whole. None where a pass is not finite.
    fn take_likelier_noise(
        &mut self,
        problem: &Problem,
        physics: &Physics,
        noise: &[Noise],
        which: Range<usize>,
    ) -> Option<()> {
        let likelier = |index: usize| self.likelier(problem, physics, index, noise[index]);
        let found: Option<Vec<Option<(Noise, Evaluation)>>> = which.clone().into_par_iter().map(likelier).collect();
        for (index, found) in which.zip(found?) {
            let Some((noise, evaluation)) = found else { continue };
            self.noise[index] = noise;
            self.evaluation.blocks.splice(index..=index, evaluation.blocks);
            self.evaluation.innovations.splice(index..=index, evaluation.innovations);
        }
        self.log_likelihood = self.evaluation.fitted(problem);
        Some(())
    }

    /// The first noise on the way back from another one under which a recording is likelier, and the recording under it; an inner none
    /// where there is none.
    fn likelier(
        &self,
        problem: &Problem,
        physics: &Physics,
        index: usize,
        mut tried: Noise,
    ) -> Option<Option<(Noise, Evaluation)>> {
        let own = self.noise[index];
        let mut noise = self.noise.clone();
        for _ in 0..HALVINGS_OF_NOISE {
            if tried == own {
                break;
            }
            noise[index] = tried;
            let found = evaluate(problem, physics, &noise, index..index + 1)?;
            let rise = found.blocks.iter().flatten().sum::<f64>() - self.evaluation.blocks[index].iter().sum::<f64>();
            if rise > 0.0 {
                return Some(Some((tried, found)));
            }
            if rise >= -PROMISED_BY_NOISE {
                break;
            }
            tried = own.halfway_to(&tried);
        }
        Some(None)
    }
}

/// How often the way to another noise is halved, on the scale of its logarithm, until a recording as a whole is likelier.
const HALVINGS_OF_NOISE: usize = 3;

/// Log-likelihood below which a step has found nothing more: a hundredth of what any test asks for.
pub(super) const SETTLED: f64 = 0.05;

/// Fits the free values, and the noise with them, from where they are, in at most `rounds` steps, and to the top of the likelihood itself.
pub fn refit(problem: &Problem, start: &Hypothesis, noise: &[Noise], rounds: usize) -> Option<Refitted> {
    fitted(problem, start, noise, rounds, by_differences)
}

/// The same as far as the linearised pass leads, which ranks.
pub(crate) fn refit_linearised(
    problem: &Problem,
    start: &Hypothesis,
    noise: &[Noise],
    rounds: usize,
) -> Option<Refitted> {
    fitted(problem, start, noise, rounds, |_, best, _| best)
}

/// With what is to be done `at_the_end`, under the information of the last step.
fn fitted(
    problem: &Problem,
    start: &Hypothesis,
    noise: &[Noise],
    rounds: usize,
    at_the_end: fn(&Problem, Refitted, Option<&DMatrix<f64>>) -> Refitted,
) -> Option<Refitted> {
    let mut best = at(problem, start.clone(), noise.to_vec())?;
    let mut damping = FIRST_DAMPING;
    let mut estimated: Option<Estimated> = None;
    for round in 0..rounds {
        if problem.is_spent() {
            break;
        }
        let before = best.log_likelihood;
        let information;
        (best, information) = stepped(problem, best, &mut damping)?;
        // At the end always: what was promised is of the noise's scale, and its parts may have moved against each other.
        let settled = best.log_likelihood - before < SETTLED;
        if settled || estimated.as_ref().is_none_or(|then| then.is_off(problem, &Estimated::on(&best))) {
            best = with_its_noise(problem, best)?;
            estimated = Some(Estimated::on(&best));
        }
        let rises = |best: &Refitted| best.log_likelihood - before >= 10.0 * SETTLED;
        let ends = settled && !rises(&best);
        if ends || round + 1 == rounds {
            let places = best.hypothesis.rough();
            best = searched(problem, best, &places, FINEST_OF_ROUGH);
            best = at_the_end(problem, best, information.as_ref());
        }
        if ends && !rises(&best) {
            break;
        }
    }
    Some(best)
}

/// The same under noise that stays as it is.
pub fn refit_under(problem: &Problem, start: &Hypothesis, noise: &[Noise], rounds: usize) -> Option<Refitted> {
    let mut best = at(problem, start.clone(), noise.to_vec())?;
    let mut damping = FIRST_DAMPING;
    for _ in 0..rounds {
        let before = best.log_likelihood;
        if !problem.is_spent() {
            (best, _) = stepped(problem, best, &mut damping)?;
        }
        if best.log_likelihood - before < SETTLED {
            break;
        }
    }
    Some(best)
}

/// Damping of the first step: next to none, for most starts are near.
pub(super) const FIRST_DAMPING: f64 = 1e-3;

/// One step of the values, those that no derivative tells with the others, and the information of those that derivatives tell.
fn stepped(problem: &Problem, from: Refitted, damping: &mut f64) -> Option<(Refitted, Option<DMatrix<f64>>)> {
    let many = from.hypothesis.told_by(problem);
    let path = kept(problem, &from.hypothesis.physics(&problem.nominal), &from.noise, many)?;
    let (best, information) = match normal_equations(problem, &from.hypothesis, &path) {
        Some((information, gradient)) => {
            (descended(problem, from, &information, &gradient, damping), Some(information))
        }
        None => (from, None),
    };
    let places = best.hypothesis.searched();
    Some((searched(problem, best, &places, FINEST), information))
}

fn on_excerpts(problem: &Problem, physics: &Physics, from: &[Noise], which: Range<usize>) -> Vec<Noise> {
    noise_of(problem, physics, from, 0.5, which)
}

/// With the noise that goes with its values.
fn with_its_noise(problem: &Problem, mut found: Refitted) -> Option<Refitted> {
    let physics = found.hypothesis.physics(&problem.nominal);
    let told_by = 0..found.hypothesis.told_by(problem);
    let noise = on_excerpts(problem, &physics, &found.noise, told_by.clone());
    found.take_likelier_noise(problem, &physics, &noise, told_by)?;
    Some(found)
}

/// Log-likelihood that another estimate of the noise must promise: what the estimate itself is settled to.
const PROMISED_BY_NOISE: f64 = 0.5;

/// What the noise was estimated on.
struct Estimated {
    log_likelihood: f64,
    /// Mean product of the whitened innovations with the slope of their loss, one a recording: one where a noise has no bounds.
    scales: Vec<f64>,
}

impl Estimated {
    fn on(found: &Refitted) -> Self {
        let of = |innovations: &Innovations| {
            let counted = innovations.whitened.iter().zip(&innovations.counted).filter(|(_, counted)| **counted);
            let add = |(sum, many), size: f64| (sum + size * size.min(HUBER), many + 1.0);
            let (sum, many) = counted.map(|(whitened, _)| whitened.abs()).fold((0.0, 0.0), add);
            sum / f64::max(many, 1.0)
        };
        let scales = found.evaluation.innovations.iter().map(of).collect();
        Self { log_likelihood: found.log_likelihood, scales }
    }

    /// Whether another estimate is worth its passes: a scale that is off by a share costs its square for every residual, and what a
    /// model gains is such a share.
    fn is_off(&self, problem: &Problem, now: &Self) -> bool {
        let gained = now.log_likelihood - self.log_likelihood;
        let of = |(index, (then, now)): (usize, (&f64, &f64))| {
            let rows = problem.excerpts[index].iter().map(Range::len).sum::<usize>().max(1) as f64;
            let off = 0.5 * (now - then);
            let costs = rows * off * off + gained * gained / rows;
            costs.is_nan() || costs >= PROMISED_BY_NOISE
        };
        self.scales.iter().zip(&now.scales).enumerate().any(of)
    }
}

/// Steps that are tried before one that rises is given up, each with this many times the damping: from a full step to none.
const DAMPED: usize = 4;
const MORE_DAMPING: f64 = 30.0;
/// A step that promises less than this is not worth a pass: the values are within a seventh of a standard deviation.
const PROMISED: f64 = 0.2 * SETTLED;

fn descended(
    problem: &Problem,
    from: Refitted,
    information: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: &mut f64,
) -> Refitted {
    for _ in 0..DAMPED {
        let Some((tried, promised)) = moved_by(problem, &from.hypothesis, information, gradient, *damping) else {
            return from;
        };
        if promised < PROMISED {
            return from;
        }
        if let Some(found) = at(problem, tried, from.noise.clone())
            && found.log_likelihood > from.log_likelihood
        {
            *damping = (*damping * 0.1).max(1e-9);
            return found;
        }
        *damping = (*damping * MORE_DAMPING).max(1e-4);
    }
    from
}

pub(super) fn at(problem: &Problem, hypothesis: Hypothesis, noise: Vec<Noise>) -> Option<Refitted> {
    let many = hypothesis.told_by(problem);
    let evaluation = evaluate(problem, &hypothesis.physics(&problem.nominal), &noise, 0..many)?;
    let log_likelihood = evaluation.fitted(problem);
    Some(Refitted { hypothesis, noise, evaluation, log_likelihood })
}

/// Scales of the free values, and bounds.
pub(crate) fn ranges(problem: &Problem, hypothesis: &Hypothesis) -> Vec<crate::effects::Range> {
    let of = |&(entry, index): &(usize, usize)| {
        let entry = &hypothesis.entries[entry];
        entry.effect.ranges(entry.values.len(), &problem.nominal, &problem.excitation)[index]
    };
    hypothesis.free().iter().map(of).collect()
}

/// Derivatives of the whitened innovations by the free values, over a hundredth of a typical change: one column a value, each of one vector
/// a recording.
pub(crate) fn columns(problem: &Problem, hypothesis: &Hypothesis, path: &Kept) -> Vec<Option<Vec<Vec<f64>>>> {
    let places = hypothesis.free();
    let ranges = ranges(problem, hypothesis);
    places
        .par_iter()
        .zip(ranges)
        .map(|(&place, range)| {
            let step = range.allowed(hypothesis.entries[place.0].values[place.1], 0.01 * range.scale);
            let column = |step: f64| {
                let other = hypothesis.moved(place, step).physics(&problem.nominal);
                let mut column = path.response(problem, &other)?;
                column.iter_mut().flatten().for_each(|value| *value /= step);
                Some(column)
            };
            column(step).or_else(|| column(-step))
        })
        .collect()
}

/// The normal equations of one recording: one column a value, each of one vector a recording.
pub(crate) struct Equations<'a> {
    innovations: &'a Innovations,
    columns: &'a [Vec<Vec<f64>>],
    recording: usize,
    /// Which values the recording tells.
    told: &'a [bool],
}

impl KeptRecording {
    pub(crate) fn equations<'a>(
        &'a self,
        columns: &'a [Vec<Vec<f64>>],
        recording: usize,
        told: &'a [bool],
    ) -> Equations<'a> {
        Equations { innovations: &self.innovations, columns, recording, told }
    }
}

impl Equations<'_> {
    /// Adds what some rows tell to a gradient and to the lower triangle of an information.
    pub(crate) fn add_rows(&self, rows: Range<usize>, gradient: &mut DVector<f64>, information: &mut DMatrix<f64>) {
        let many = self.columns.len();
        for row in rows.filter(|&row| self.innovations.counted[row]) {
            let whitened = self.innovations.whitened[row];
            let weight = (HUBER / whitened.abs()).min(1.0);
            for i in (0..many).filter(|&i| self.told[i]) {
                let a = weight * self.columns[i][self.recording][row];
                gradient[i] -= a * whitened;
                for j in (0..=i).filter(|&j| self.told[j]) {
                    information[(i, j)] += a * self.columns[j][self.recording][row];
                }
            }
        }
    }
}

fn normal_equations(problem: &Problem, hypothesis: &Hypothesis, path: &Kept) -> Option<(DMatrix<f64>, DVector<f64>)> {
    // A value that the plant lets go neither way is held where it is.
    let still = || path.recordings.iter().map(|kept| vec![0.0; kept.innovations.whitened.len()]).collect();
    let columns: Vec<Vec<Vec<f64>>> =
        columns(problem, hypothesis, path).into_iter().map(|column| column.unwrap_or_else(still)).collect();
    let many = columns.len();
    if many == 0 {
        return None;
    }
    let (mut information, mut gradient) = (DMatrix::zeros(many, many), DVector::zeros(many));
    let alone = hypothesis.alone();
    for (index, kept) in path.recordings.iter().enumerate() {
        // What is held out tells nothing but the values that belong to it alone.
        let told: Vec<bool> = alone.iter().map(|of| index < problem.fitted || *of == Some(index)).collect();
        let of_recording = kept.equations(&columns, index, &told);
        of_recording.add_rows(0..kept.innovations.whitened.len(), &mut gradient, &mut information);
    }
    information.fill_upper_triangle_with_lower_triangle();
    information.iter().all(|value: &f64| value.is_finite()).then_some((information, gradient))
}

/// The values one step on, and the log-likelihood that the linear model promises.
pub(super) fn moved_by(
    problem: &Problem,
    hypothesis: &Hypothesis,
    information: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
) -> Option<(Hypothesis, f64)> {
    let ranges = ranges(problem, hypothesis);
    let mut damped = information.clone();
    for (i, range) in ranges.iter().enumerate() {
        // A value that nothing tells is held by a prior of ten typical changes.
        damped[(i, i)] += damping * information[(i, i)] + 0.01 / (range.scale * range.scale);
    }
    let step = damped.cholesky()?.solve(gradient);
    let promised = step.dot(gradient) - 0.5 * step.dot(&(information * &step));
    let mut next = hypothesis.clone();
    for ((&(entry, index), range), step) in hypothesis.free().iter().zip(&ranges).zip(step.iter()) {
        let value = &mut next.entries[entry].values[index];
        *value = (*value + step).max(range.low).min(range.high);
    }
    next.entries.iter().all(|entry| entry.values.iter().all(|value| value.is_finite())).then_some((next, promised))
}
