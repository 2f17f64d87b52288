//! Whether recordings need the same torque noise: one machine has one, and a filter takes what its model leaves out for more of it, in each
//! recording as much as that one's motion brings out.
//!
//! Cochran's test (1954) of the logarithms of the noise densities, each with the sandwich variance of its own blocks, so that a noise that is
//! not normal or changes within a recording counts for less. The sensor's noise may differ, for rounding is not the same at every speed.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::Predictor;
use crate::confidence_set::{OTHER_NOISE, TWO_SIDED_95, add_spread};
use crate::hypothesis::{Refitted, evaluate};
use crate::likelihood::Noise;
use crate::problem::Problem;
use crate::search::SMALLEST_GAIN;
use crate::windows::window_s;

/// Step of the differences in the logarithm of a standard deviation: where the noise estimate takes its likelihood for a parabola.
const STEP: f64 = 0.25 * std::f64::consts::LN_2;

/// The logarithm of one recording's torque noise density.
struct Density {
    value: f64,
    variance: f64,
    blocks: usize,
}

/// The test of what is left; none where the least noise is within what a density is known to of the mean of the lower ends of their 95 %
/// intervals, where fewer than two recordings tell theirs, or a pass is not finite. On tuning cases the least falls short of that mean by 0.80 to
/// 1.00 of it under five wrong names, and by less than half under nine right ones. A noise that hardly shows beside the sensor's steps is
/// estimated unevenly, and where nothing is named would be all there is to say: there the largest must be a relevant part of the drive's torque
/// too. Of 35 clean tuning cases without a name five have 0.1 to 1 % of it unevenly, and one whose drive saturates in two of three
/// recordings 12 and 25 %.
pub(super) fn by_recording(problem: &Problem, refitted: &Refitted) -> Option<Predictor> {
    let densities = densities(problem, refitted)?;
    let many = densities.len();
    let blocks: usize = densities.iter().map(|one| one.blocks).sum();
    if many < 2 || blocks <= 2 * many {
        return None;
    }
    let weight: f64 = densities.iter().map(|one| one.variance.recip()).sum();
    let mean = densities.iter().map(|one| one.value / one.variance).sum::<f64>() / weight;
    let statistic: f64 = densities.iter().map(|one| (one.value - mean).powi(2) / one.variance).sum();
    let freedom = many - 1;
    // Each recording gave two numbers.
    let chance = FisherSnedecor::new(freedom as f64, (blocks - 2 * many) as f64).ok()?;
    let least = densities.iter().map(|one| one.value.exp()).fold(f64::INFINITY, f64::min);
    // What a recording does not tell makes no mean larger.
    let at_least = |one: &Density| (one.value - TWO_SIDED_95 * one.variance.sqrt()).exp().max(least);
    let share = 1.0 - least / (densities.iter().map(at_least).sum::<f64>() / many as f64);
    let named = !refitted.hypothesis.entries.is_empty();
    let largest = densities.iter().map(at_least).fold(0.0, f64::max);
    let felt = || (largest / window_s(problem, 1)).sqrt() >= SMALLEST_GAIN * problem.excitation.torque_rms;
    (statistic.is_normal() && share > 1.0 - OTHER_NOISE && (named || felt())).then(|| Predictor {
        channel: "recording",
        share,
        rise: 0.5 * statistic,
        freedom,
        p_value: chance.sf(statistic / freedom as f64),
        torque_rms: None,
    })
}

/// Of the recordings that tell it.
fn densities(problem: &Problem, refitted: &Refitted) -> Option<Vec<Density>> {
    let physics = refitted.hypothesis.physics(&problem.nominal);
    let blocks_under = |[torque, sensor]: [f64; 2]| {
        let noise: Vec<Noise> = refitted.noise.iter().map(|noise| changed(noise, torque, sensor)).collect();
        Some(evaluate(problem, &physics, &noise, 0..problem.recordings.len())?.blocks)
    };
    let around = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, 1.0], [-1.0, -1.0]];
    let around: Vec<Vec<Vec<f64>>> = around.into_iter().map(blocks_under).collect::<Option<_>>()?;
    let of = |(index, noise): (usize, &Noise)| {
        let sides: Vec<&[f64]> = around.iter().map(|side| side[index].as_slice()).collect();
        let blocks = refitted.evaluation.blocks.get(index)?;
        let (value, variance) = (noise.slow_density().ln(), variance(blocks, &sides)?);
        Some(Density { value, variance, blocks: blocks.len() })
    };
    Some(refitted.noise.iter().enumerate().filter_map(of).collect())
}

/// With standard deviations larger by so many steps.
fn changed(noise: &Noise, torque: f64, sensor: f64) -> Noise {
    let noise = noise.with_torque_share((2.0 * torque * STEP).exp());
    Noise { sensor_sd: noise.sensor_sd * (sensor * STEP).exp(), ..noise }
}

/// Sandwich variance of the logarithm of the density, from the log-likelihood of the blocks and that a step up and down in the torque's noise,
/// in the sensor's and in both; never less than the information alone says. None where the likelihood has no top.
fn variance(blocks: &[f64], sides: &[&[f64]]) -> Option<f64> {
    let [torque_up, torque_down, sensor_up, sensor_down, both_up, both_down] = sides else { return None };
    let bend = |up: &[f64], down: &[f64]| -> f64 {
        blocks.iter().zip(up).zip(down).map(|((at, up), down)| 2.0 * at - up - down).sum::<f64>()
    };
    let (torque, sensor) = (bend(torque_up, torque_down), bend(sensor_up, sensor_down));
    let mixed = 0.5 * (bend(both_up, both_down) - torque - sensor);
    // The sensor's noise is no free number where it is at its least, or where the motion is given.
    let free = sensor > 0.0 && torque * sensor > mixed * mixed;
    if torque <= 0.0 {
        return None;
    }
    let many = if free { 2 } else { 1 };
    let information = DMatrix::from_fn(many, many, |i, j| [[torque, mixed], [mixed, sensor]][i][j]);
    let score = |block: usize| {
        DVector::from_fn(many, |i, _| {
            let (up, down) = [(torque_up, torque_down), (sensor_up, sensor_down)][i];
            0.5 * (up[block] - down[block])
        })
    };
    let scores: Vec<DVector<f64>> = (0..blocks.len()).map(score).collect();
    let mean = scores.iter().sum::<DVector<f64>>() / blocks.len() as f64;
    let scores: Vec<DVector<f64>> = scores.into_iter().map(|score| score - &mean).collect();
    let mut spread = DMatrix::zeros(many, many);
    add_spread(&mut spread, &scores);
    let inverse = information.cholesky()?.inverse();
    let sandwich = (&inverse * spread * &inverse)[(0, 0)].max(inverse[(0, 0)]);
    // A density is a square.
    let variance = (2.0 * STEP).powi(2) * sandwich;
    (variance.is_finite() && variance > 0.0).then_some(variance)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the two numbers tell of each other, in the information of a parabola.
    const MIXED: f64 = 0.5;

    /// Variance in steps of eight blocks with these slopes along the torque's noise, and an information of one each.
    fn of_slopes(slopes: [f64; 8]) -> f64 {
        let at = |x: f64, y: f64| slopes.map(|slope| slope * x - 0.5 * (x * x + y * y) - MIXED * x * y);
        let sides = [at(1.0, 0.0), at(-1.0, 0.0), at(0.0, 1.0), at(0.0, -1.0), at(1.0, 1.0), at(-1.0, -1.0)];
        let sides: Vec<&[f64]> = sides.iter().map(<[f64; 8]>::as_slice).collect();
        variance(&at(0.0, 0.0), &sides).unwrap_or(f64::NAN) / (2.0 * STEP).powi(2)
    }

    #[test]
    fn blocks_that_agree_leave_what_the_information_says() {
        // The inverse of 8 and 4 beside 4 and 8.
        assert!((of_slopes([0.0; 8]) - 1.0 / 6.0).abs() < 1e-12);
        assert!((of_slopes([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0]) - 1.0 / 6.0).abs() < 1e-12);
    }

    #[test]
    fn a_noise_that_changes_within_a_recording_counts_for_less() {
        // Squares of 72, 60 with the next and 12 with the next but one, times the square of the inverse.
        let halves = [3.0, 3.0, 3.0, 3.0, -3.0, -3.0, -3.0, -3.0];
        assert!((of_slopes(halves) - 144.0 / 36.0).abs() < 1e-12, "{}", of_slopes(halves));
    }

    #[test]
    fn a_likelihood_without_a_top_tells_nothing() {
        let flat = [0.0; 8];
        let sides: [&[f64]; 6] = [&flat; 6];
        assert!(variance(&flat, &sides).is_none());
    }
}
