//! What is left of the best hypothesis, and whether that is more than noise: the goodness of fit with what was tried and not taken.

use crate::confidence_set::{LEVEL_OF_THE_SET, SMALLEST_SIZE};
use crate::effects::Effect;
use crate::goodness::{Predictor, predictors};
use crate::hypothesis::{Refitted, noise_of};
use crate::likelihood::Noise;
use crate::problem::Problem;
use crate::search::{Found, Rejected, SMALLEST_GAIN, fall};
use crate::windows::window_s;

/// What is left and predictable.
#[derive(Debug, Clone, PartialEq)]
pub struct Remainder {
    /// Torque that the noise model has to stand in for, root mean square, N m (N).
    pub torque_rms: f64,
    /// Channels that predict part of what is left, best first.
    pub predictors: Vec<Predictor>,
    /// Effects that would certainly add to the likelihood, but are not worth a name: they bring the motion too little, or no nearer.
    pub unnamed: Vec<&'static Effect>,
}

/// What is left is told as the mean torque over this time, s: longer than the sensor's noise, shorter than motion.
const REMAINDER_S: f64 = 0.02;

/// The torque that the noise stands in for, root mean square of its means, N m (N): what the samples say is missing, but no more than the
/// noise has of it. Where a recording begins, samples tell a speed that was not known, and no torque.
fn torque_rms(problem: &Problem, refitted: &Refitted) -> f64 {
    let (mut squares, mut count) = (0.0, 0_usize);
    for (recorded, innovations) in problem.recordings.iter().zip(&refitted.evaluation.innovations) {
        let rows = ((REMAINDER_S / recorded.period_s().max(f64::MIN_POSITIVE)).round() as usize).max(1);
        for torques in innovations.left_torque.chunks_exact(rows) {
            let torque = torques.iter().sum::<f64>() / rows as f64;
            squares += torque * torque;
            count += 1;
        }
    }
    (squares / count.max(1) as f64).min(slow_density(refitted) / REMAINDER_S).sqrt()
}

/// Spectral density of the torque noise at low frequencies, mean of the recordings, (N m)^2 s.
fn slow_density(refitted: &Refitted) -> f64 {
    refitted.noise.iter().map(Noise::slow_density).sum::<f64>() / refitted.noise.len().max(1) as f64
}

/// Smallest relevant torque over the drive's where nothing is named: the smallest size of what is named, a fiftieth, of the typical
/// change of a torque, 5 %.
const SMALLEST_TORQUE: f64 = SMALLEST_SIZE * 0.05;

/// Relative fall of windows' root mean square if a steady torque of that size were known: over the longer horizon it adds to the mean
/// torque that the noise leaves there.
fn share_of_windows(problem: &Problem, refitted: &Refitted, torque_rms: f64) -> f64 {
    let horizon_s = window_s(problem, 1);
    let noise = (slow_density(refitted) / horizon_s.max(f64::MIN_POSITIVE)).max(f64::MIN_POSITIVE);
    1.0 - (1.0 + torque_rms * torque_rms / noise).sqrt().recip()
}

/// What is left, if a channel predicts a relevant part of it, or if another effect certainly adds a relevant part to the likelihood.
pub(crate) fn remainder(problem: &Problem, found: &Found) -> Option<Remainder> {
    let refitted = &found.best.assessed.refitted;
    let white = if refitted.hypothesis.entries.is_empty() { without_memory(problem, refitted) } else { None };
    let looks = if white.is_some() { 2 } else { 1 };
    let mut predictors = relevant(problem, refitted, looks);
    if predictors.is_empty() {
        predictors = white.map_or_else(Vec::new, |white| of_state(relevant(problem, &white, looks)));
    }
    let unnamed: Vec<&'static Effect> = unnamed(problem, found);
    (!predictors.is_empty() || !unnamed.is_empty()).then(|| Remainder {
        torque_rms: torque_rms(problem, refitted),
        predictors,
        unnamed,
    })
}

/// The nominal machine under noise without a memory, where it has one: a memory stands in for any slow torque that is missing, and hides
/// from the score what it depends on. Beside effects it stands in for what their own passes leave, less than a thousandth of the
/// drive's torque. Blocks give the score its spread, so a noise that does have a memory predicts no more by chance.
/// None without one, or where a pass is not finite.
fn without_memory(problem: &Problem, refitted: &Refitted) -> Option<Refitted> {
    refitted.noise.iter().find(|noise| noise.colour.is_some())?;
    let from: Vec<Noise> =
        refitted.noise.iter().map(|noise| Noise::white(noise.sensor_sd, noise.slow_density())).collect();
    let physics = refitted.hypothesis.physics(&problem.nominal);
    let noise = noise_of(problem, &physics, &from, OCTAVES, 0..problem.recordings.len());
    Some(Refitted { noise, ..refitted.clone() })
}

/// First step of the search for the noise without a memory: its density at low frequencies is a start that is some factors of two off.
const OCTAVES: f64 = 1.0;

/// Without what is predicted from its own past, which a noise with a memory is.
fn of_state(predictors: Vec<Predictor>) -> Vec<Predictor> {
    predictors.into_iter().filter(|one| one.torque_rms.is_some()).collect()
}

/// The channels that predict a relevant part, at a level that is shared by so many looks.
fn relevant(problem: &Problem, refitted: &Refitted, looks: usize) -> Vec<Predictor> {
    let all = predictors(problem, refitted);
    let level = LEVEL_OF_THE_SET / (looks * all.len()).max(1) as f64;
    // Beside effects the least counts, for their values may have absorbed more of it.
    let alone = refitted.hypothesis.entries.is_empty();
    let least = if alone { SMALLEST_TORQUE * problem.excitation.torque_rms } else { 0.0 };
    let windows = |one: &Predictor| {
        let torque_rms = one.torque_rms.filter(|torque_rms| *torque_rms >= least);
        torque_rms.map_or(0.0, |torque_rms| share_of_windows(problem, refitted, torque_rms))
    };
    let worth_it = |one: &Predictor| one.p_value < level && one.rise > problem.price() * one.freedom as f64;
    // A memory of the noise is no physics that was left out until it is a relevant part of what is left.
    let relevant = |one: &Predictor| one.share.max(windows(one)) >= SMALLEST_GAIN;
    all.into_iter().filter(|one| worth_it(one) && relevant(one)).collect()
}

/// Effects that were refitted beside the best, certainly add to its likelihood, and by a relevant part: of what it gained, or, where
/// nothing was, of the innovations' size, if they bring the motion nearer too. The likelihood tells that something is left; the windows
/// have told that it is not this.
fn unnamed(problem: &Problem, found: &Found) -> Vec<&'static Effect> {
    let gained = found.best.assessed.refitted.log_likelihood - found.nominal.assessed.refitted.log_likelihood;
    let is_part = |one: &&Rejected| match found.best.assessed.refitted.hypothesis.entries.is_empty() {
        true => one.gain.is_some_and(|gain| gain > 0.0) && fall(problem, one.rise) >= SMALLEST_GAIN,
        false => one.rise >= SMALLEST_GAIN * gained,
    };
    found.rejected.iter().filter(|one| one.certain).filter(is_part).map(|one| one.effect).collect()
}
