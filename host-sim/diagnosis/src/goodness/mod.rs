//! Whether what is left is predictable: from state, from its own past, over time. One test for every channel and machine.
//!
//! What a channel may predict is a torque that is a smooth function of it: columns of the linearised likelihood beside those of
//! the hypothesis. Their score is tested (Rao 1948) with the spread that blocks of it show, so that nothing hangs on the noise model.

mod channels;
mod homogeneity;
mod score_test;

use rayon::prelude::*;

use crate::hypothesis::{Refitted, kept};
use crate::problem::Problem;

use channels::{Channel, channels};
use homogeneity::by_recording;
use score_test::Left;

/// How well one channel predicts what is left.
#[derive(Debug, Clone, PartialEq)]
pub struct Predictor {
    /// The channel, as `speed`.
    pub channel: &'static str,
    /// Share of the whitened residual's squares, or of those that noise would leave, that it predicts beyond what as many columns do
    /// by chance, 1.
    pub share: f64,
    /// Log-likelihood that this prediction adds.
    pub rise: f64,
    /// Columns that it takes.
    pub freedom: usize,
    /// Probability of its score by chance.
    pub p_value: f64,
    /// Root mean square of the torque it predicts, N m (N); none for what stands in no torque, as a memory of the noise.
    pub torque_rms: Option<f64>,
}

/// Tests every channel; best first.
pub fn predictors(problem: &Problem, refitted: &Refitted) -> Vec<Predictor> {
    let physics = refitted.hypothesis.physics(&problem.nominal);
    let Some(path) = kept(problem, &physics, &refitted.noise, problem.recordings.len()) else { return Vec::new() };
    let left = Left::new(problem, &refitted.hypothesis, &path);
    let test = |channel: &Channel| {
        let columns: Vec<Vec<f64>> = channel.columns(problem, &path);
        let found = left.test(&columns)?;
        Some(Predictor {
            channel: channel.name,
            share: found.share,
            rise: found.rise,
            freedom: found.coefficients.len(),
            p_value: found.p_value,
            torque_rms: channel.torque_rms(&found.coefficients),
        })
    };
    let mut all: Vec<Predictor> = channels(problem, &path).par_iter().filter_map(test).collect();
    all.extend(by_recording(problem, refitted));
    all.sort_by(|a, b| b.share.total_cmp(&a.share));
    all
}
