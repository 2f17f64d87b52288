//! How noisy a recording is: torque and position apart.

use crate::read::Recording;
use crate::screen::{Fit, Problem};

/// Changes between neighbours that an estimate needs.
const ENOUGH: usize = 20;

/// Noise of one recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation of a white torque held over each row, N m (N).
    pub torque: f64,
    /// Standard deviation of the position samples before they are rounded, rad (m).
    pub position: f64,
    /// Step of the position, rad (m).
    pub resolution: f64,
}

/// Noise of recording number `index` from what a fit leaves of it.
///
/// The residual of a bump minus the mean of its neighbours holds torque noise by the weights of the cells and position
/// noise by those of the samples. The position's is known from the smoother; what remains in each width is the torque's,
/// and the widths are weighed by how well they tell it. Medians, so that events and what is still missing hardly count.
pub fn estimate(problem: &Problem, fit: &Fit, weights: &[f64], index: usize, resolution: f64) -> Noise {
    let motion = &problem.motions[index];
    // Residuals are accelerations times the nominal inertia.
    let nominal = problem.nominal.inertia;
    let scale = problem.machine(&fit.active).inertia / nominal;
    let rounding = resolution / 12.0_f64.sqrt();
    let total = motion.noise.max(rounding);
    let widths: Vec<Changes> = (0..3)
        .filter_map(|width| changes(problem, fit, weights, (index, width)))
        .map(|changes| changes.with_position_noise(nominal * total))
        .collect();
    Noise {
        torque: scale * combined(&widths).sqrt(),
        position: (total * total - rounding * rounding).max(0.0).sqrt(),
        resolution,
    }
}

/// How much the bumps of one width differ from their neighbours.
struct Changes {
    /// Square of the standard deviation, (N m)^2.
    square: f64,
    count: f64,
    /// Sum of squares of the weights of the torque of a row.
    torque_gain: f64,
    /// Sum of squares of the weights of the position, 1/s4.
    position_gain: f64,
    /// What position noise explains of the square.
    from_position: f64,
}

impl Changes {
    fn with_position_noise(self, torque_per_acceleration: f64) -> Self {
        Self { from_position: torque_per_acceleration * torque_per_acceleration * self.position_gain, ..self }
    }
}

/// Variance of the torque over all widths, each weighed by the inverse of its variance under the variance found.
fn combined(widths: &[Changes]) -> f64 {
    let mut variance = 0.0;
    for _ in 0..4 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for width in widths {
            let apparent = variance + width.from_position / width.torque_gain;
            let weight = width.count / (apparent * apparent).max(1e-300);
            sum += weight * (width.square - width.from_position) / width.torque_gain;
            weights += weight;
        }
        variance = if weights > 0.0 { (sum / weights).max(0.0) } else { 0.0 };
    }
    variance
}

/// Changes of one recording and width; none from too few.
fn changes(problem: &Problem, fit: &Fit, weights: &[f64], (recording, width): (usize, usize)) -> Option<Changes> {
    let own: Vec<usize> = (0..problem.equations.len())
        .filter(|&i| problem.equations[i].recording == recording && problem.equations[i].width == width)
        .collect();
    let t_s = &problem.motions[recording].t_s;
    let (mut sizes, mut torque_gain, mut position_gain) = (Vec::new(), Vec::new(), Vec::new());
    for three in own.windows(3) {
        let rows = [0, 1, 2].map(|k| &problem.equations[three[k]].row);
        // Only rows whose neighbours are both there.
        let (first, last) = (rows[1].first_cell, rows[1].first_cell + rows[1].cell.len());
        let half_width_s = 0.5 * (t_s[last] - t_s[first]);
        if rows[2].centre_s - rows[0].centre_s > 1.2 * half_width_s {
            continue;
        }
        let raw = [0, 1, 2].map(|k| fit.residual[three[k]] / weights[three[k]]);
        sizes.push((raw[1] - 0.5 * (raw[0] + raw[2])).abs());
        torque_gain.push(shared_squares(rows.map(|row| (row.first_cell, row.cell.as_slice()))));
        position_gain.push(shared_squares(rows.map(|row| (row.first_sample, row.second.as_slice()))));
    }
    if sizes.len() < ENOUGH {
        return None;
    }
    let count = sizes.len() as f64;
    let square = (1.4826 * median(&mut sizes)).powi(2);
    let (torque_gain, position_gain) = (median(&mut torque_gain), median(&mut position_gain));
    Some(Changes { square, count, torque_gain, position_gain, from_position: 0.0 })
}

/// Sum of squares of the middle weights minus half of each neighbour's; weights by their first index.
fn shared_squares(rows: [(usize, &[f64]); 3]) -> f64 {
    let from = rows.iter().map(|(first, _)| *first).min().unwrap_or(0);
    let to = rows.iter().map(|(first, weights)| first + weights.len()).max().unwrap_or(0);
    let mut combined = vec![0.0; to - from];
    for ((first, weights), factor) in rows.iter().zip([-0.5, 1.0, -0.5]) {
        for (offset, weight) in weights.iter().enumerate() {
            combined[first - from + offset] += factor * weight;
        }
    }
    combined.iter().map(|weight| weight * weight).sum()
}

fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Root mean square about their mean of the samples in windows at rest: as recorded, and as the estimated sensor would
/// read the same places, rad (m). None without rest.
pub(super) fn at_rest(recording: &Recording, noise: &Noise, horizon_s: f64, seed: u64) -> Option<(f64, f64)> {
    let sampler = plant::sensor::SamplerConfig {
        resolution: noise.resolution,
        noise_sd: noise.position,
        ..plant::sensor::SamplerConfig::default()
    };
    let mut sampler = plant::sensor::Sampler::new(sampler, seed).ok()?;
    let (mut recorded, mut expected, mut count) = (Vec::new(), Vec::new(), 0);
    let mut start = 0;
    while start < recording.rows() {
        let end = recording.t_s.partition_point(|t| *t < recording.t_s[start] + horizon_s);
        let window = &recording.position[start..end];
        if rests(window, noise.resolution) {
            let drawn: Vec<f64> = window.iter().map(|_| sampler.measure(mean(window))).collect();
            recorded.push(squares_about_mean(window) / window.len() as f64);
            expected.push(squares_about_mean(&drawn) / window.len() as f64);
            count += window.len();
        }
        start = end.max(start + 1);
    }
    // A few windows in which the rotor creeps do not count.
    let median = |mut squares: Vec<f64>| {
        squares.sort_by(f64::total_cmp);
        squares[squares.len() / 2].sqrt()
    };
    (count >= 100).then(|| (median(recorded), median(expected)))
}

/// Whether nothing moves in a window: the means of its quarters differ by no more than a step and what their own scatter
/// makes likely.
fn rests(window: &[f64], resolution: f64) -> bool {
    let length = window.len() / 4;
    if length < 2 {
        return false;
    }
    let quarters = window.chunks_exact(length);
    let (low, high) =
        quarters.clone().map(mean).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), m| (l.min(m), h.max(m)));
    let scatter = quarters.map(squares_about_mean).sum::<f64>() / window.len() as f64;
    high - low <= resolution + 4.0 * (scatter / length as f64).sqrt()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn squares_about_mean(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|value| (value - mean).powi(2)).sum()
}
