//! Whether what is left is predictable: from state, from its own past, over time. One test, cross-validated over blocks.

use statrs::distribution::{ContinuousCDF, Normal};

use crate::hypothesis::{Refitted, kept};
use crate::likelihood::filter::HUBER;
use crate::problem::Problem;

/// How well one channel predicts what is left.
#[derive(Debug, Clone, PartialEq)]
pub struct Predictor {
    /// The channel with its unit, as `speed_rad_s`.
    pub channel: &'static str,
    /// Share of the whitened residual's squares that it predicts in blocks it was not fitted on, 1.
    pub share: f64,
    /// Probability of that by chance.
    pub p_value: f64,
    /// Root mean square of the torque it predicts, N m (N).
    pub torque_rms: f64,
}

/// Bins of a channel: enough for a friction curve, each with hundreds of rows in a recording of a few seconds.
const BINS: usize = 16;
/// Rows over which a command changes.
const RATE_ROWS: usize = 5;
/// Folds of the cross-validation.
const FOLDS: usize = 5;

/// Tests every channel; best first.
pub fn predictors(problem: &Problem, refitted: &Refitted) -> Vec<Predictor> {
    let physics = refitted.hypothesis.physics(&problem.nominal);
    let Some(path) = kept(problem, &physics, &refitted.noise, problem.recordings.len()) else { return Vec::new() };
    let mut steady = physics.clone();
    // Without any torque in the column a torque of one serves as well: the response is taken as linear.
    let torque = problem.excitation.torque_rms;
    let unit = if torque > 0.0 { 0.01 * torque } else { 1.0 };
    steady.model.torque_offset += unit;
    // Whitened residual that a constant torque of one leaves.
    let response = path.response(problem, &steady).map_or(0.0, |columns| {
        let all = columns.concat();
        let counted: Vec<f64> = all.into_iter().filter(|value| *value != 0.0).collect();
        (counted.iter().map(|value| value * value).sum::<f64>() / counted.len().max(1) as f64).sqrt() / unit
    });
    // Where no torque shows in any sample, what is left is none of a torque.
    let response = if response > 0.0 { response } else { f64::INFINITY };
    let mut all: Vec<Predictor> = channels(problem, &path)
        .into_iter()
        .filter_map(|(channel, values)| predictor(problem, &path, channel, &values, response))
        .collect();
    all.sort_by(|a, b| b.share.total_cmp(&a.share));
    all
}

type Channel = (&'static str, Vec<Vec<f64>>);

fn channels(problem: &Problem, path: &crate::hypothesis::Kept) -> Vec<Channel> {
    let of = |value: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..path.recordings.len())
            .map(|index| (0..problem.recordings[index].rows()).map(|row| value(index, row)).collect())
            .collect()
    };
    // A command is made of the very sample that the innovation holds: only what was there before may predict.
    let commands = |index: usize, row: usize| problem.recordings[index].commands[row.saturating_sub(1)];
    let innovations = |index: usize| &path.recordings[index].innovations;
    let mut all: Vec<Channel> = vec![
        ("speed", of(&|index, row| innovations(index).speed[row.saturating_sub(1)])),
        ("position", of(&|index, row| innovations(index).position[row])),
        ("torque", of(&|index, row| commands(index, row).torque)),
        (
            "torque_rate",
            of(&|index, row| commands(index, row).torque - commands(index, row.saturating_sub(RATE_ROWS)).torque),
        ),
        ("time", of(&|index, row| problem.recordings[index].t_s[row])),
        (
            "own_past",
            of(&|index, row| {
                (1..=8).map(|lag| if row >= lag { innovations(index).whitened[row - lag] } else { 0.0 }).sum()
            }),
        ),
    ];
    if problem.excitation.field_peak > 0.0 {
        all.push(("field", of(&|index, row| commands(index, row).field_kv_mm)));
        all.push((
            "field_rate",
            of(&|index, row| {
                commands(index, row).field_kv_mm - commands(index, row.saturating_sub(RATE_ROWS)).field_kv_mm
            }),
        ));
    }
    all
}

fn predictor(
    problem: &Problem,
    path: &crate::hypothesis::Kept,
    channel: &'static str,
    values: &[Vec<f64>],
    response: f64,
) -> Option<Predictor> {
    let mut sorted: Vec<f64> = values.concat();
    sorted.sort_by(f64::total_cmp);
    let edges: Vec<f64> = (1..BINS).map(|bin| sorted[bin * sorted.len() / BINS]).collect();
    let bin = |value: f64| edges.partition_point(|edge| *edge <= value);
    // Blocks dealt to folds in turn.
    let mut sums = vec![[(0.0, 0.0); BINS]; FOLDS];
    let mut rows: Vec<(usize, usize, f64)> = Vec::new();
    let mut block_of: Vec<usize> = Vec::new();
    let mut block_at = 0;
    for (index, kept) in path.recordings.iter().enumerate() {
        for block in &problem.blocks[index] {
            for row in block.clone().filter(|&row| kept.innovations.counted[row]) {
                let whitened = kept.innovations.whitened[row].clamp(-HUBER, HUBER);
                let (fold, cell) = (block_at % FOLDS, bin(values[index][row]));
                sums[fold][cell].0 += whitened;
                sums[fold][cell].1 += 1.0;
                rows.push((fold, cell, whitened));
                block_of.push(block_at);
            }
            block_at += 1;
        }
    }
    let prediction = |fold: usize, cell: usize| {
        let (sum, count) = (0..FOLDS)
            .filter(|other| *other != fold)
            .fold((0.0, 0.0), |(sum, count), other| (sum + sums[other][cell].0, count + sums[other][cell].1));
        // Shrunk by one row of noise: an empty bin predicts nothing.
        sum / (count + 1.0)
    };
    let mut gains = vec![0.0; block_at];
    let (mut total, mut squares) = (0.0, 0.0);
    for (&(fold, cell, whitened), &block) in rows.iter().zip(&block_of) {
        let predicted = prediction(fold, cell);
        gains[block] += whitened * whitened - (whitened - predicted).powi(2);
        total += whitened * whitened;
        squares += predicted * predicted;
    }
    let sum: f64 = gains.iter().sum();
    let mean = sum / gains.len().max(1) as f64;
    let variance: f64 = gains.iter().map(|gain| (gain - mean).powi(2)).sum();
    if !(total > 0.0 && variance > 0.0) {
        return None;
    }
    let z = sum / variance.sqrt();
    Some(Predictor {
        channel,
        share: sum / total,
        p_value: Normal::standard().sf(z),
        torque_rms: (squares / rows.len().max(1) as f64).sqrt() / response,
    })
}
