//! The noise of a window: white noise of each sample, and white torque integrated twice from the window's start on.
//!
//! Covariance of the residuals q of a window: sigma^2 I + S G G', G the double integration over the actual sample times.
//! Its Cholesky factor is never formed: the innovations of a Kalman filter on (position, speed) that starts from a known
//! state are the same whitened residuals, in a time proportional to the rows. A rotor at rest takes no torque noise.

/// Noise of one recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Noise {
    /// Variance of a position sample, rad2 (m2).
    pub position: f64,
    /// Spectral density of the unexplained acceleration, (rad/s2)2 s.
    pub acceleration: f64,
}

/// Spans and motion of a window, from which every filter over it is built.
#[derive(Debug, Clone)]
pub(super) struct Cells {
    /// Length of each cell, s.
    pub span_s: Vec<f64>,
    /// Whether the rotor moves in it.
    pub moves: Vec<bool>,
}

/// Makes residuals of one window white, of unit variance.
#[derive(Debug, Clone)]
pub(super) struct Whitener {
    gains: Vec<[f64; 2]>,
    /// One over the standard deviation of each innovation.
    scales: Vec<f64>,
}

/// Covariance of position and speed: qq, qw, ww.
type Spread = [f64; 3];

/// What a cell adds to what is not known of position and speed.
fn ahead([qq, qw, ww]: Spread, h: f64, moves: bool, intensity: f64) -> Spread {
    let (qq, qw) = (qq + h * (2.0 * qw + h * ww), qw + h * ww);
    if moves {
        [qq + intensity * h * h * h / 3.0, qw + 0.5 * intensity * h * h, ww + intensity * h]
    } else {
        // At rest the speed is known: zero.
        [qq, 0.0, 0.0]
    }
}

/// Gain of a sample, variance of its innovation, and what is left unknown.
fn updated([qq, qw, ww]: Spread, noise: f64) -> ([f64; 2], f64, Spread) {
    let variance = qq + noise;
    let gain = [qq / variance, qw / variance];
    (gain, variance, [qq * noise / variance, qw * noise / variance, ww - gain[1] * qw])
}

impl Whitener {
    /// For a start state that is exact.
    pub(super) fn new(cells: &Cells, noise: Noise) -> Self {
        let rows = cells.span_s.len() + 1;
        let (mut gains, mut scales) = (Vec::with_capacity(rows), Vec::with_capacity(rows));
        let mut spread = [0.0; 3];
        for row in 0..rows {
            if row > 0 {
                spread = ahead(spread, cells.span_s[row - 1], cells.moves[row - 1], noise.acceleration);
            }
            let (gain, variance, left) = updated(spread, noise.position);
            spread = left;
            gains.push(gain);
            scales.push(variance.sqrt().recip());
        }
        Self { gains, scales }
    }

    /// Whitens in place.
    pub(super) fn apply(&self, cells: &Cells, values: &mut [f64]) {
        let (mut q, mut w) = (0.0, 0.0);
        for (row, value) in values.iter_mut().enumerate() {
            if row > 0 {
                q += cells.span_s[row - 1] * w;
                if !cells.moves[row - 1] {
                    w = 0.0;
                }
            }
            let innovation = *value - q;
            let gain = self.gains[row];
            q += gain[0] * innovation;
            w += gain[1] * innovation;
            *value = innovation * self.scales[row];
        }
    }
}

/// Residuals of one window with its weight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample<'a> {
    /// Spans and motion.
    pub cells: &'a Cells,
    /// Residual at the best start state, rad (m).
    pub residual: &'a [f64],
    /// Between 0 for a window to leave out and 1.
    pub weight: f64,
}

/// The first innovations only find the start state.
const SETTLING: usize = 3;

/// Sum of squares, of logarithms, and of weights of the innovations for a unit variance of the position, where nothing is
/// known of the start state (so that having estimated it costs nothing).
fn surprise(samples: &[Sample<'_>], ratio: f64) -> (f64, f64, f64) {
    let (mut squares, mut logarithms, mut count) = (0.0, 0.0, 0.0);
    for sample in samples {
        let first_s = sample.cells.span_s[0];
        let mut spread = [1e4, 0.0, 1e4 / (first_s * first_s)];
        let (mut q, mut w) = (0.0, 0.0);
        for (row, value) in sample.residual.iter().enumerate() {
            if row > 0 {
                let (h, moves) = (sample.cells.span_s[row - 1], sample.cells.moves[row - 1]);
                spread = ahead(spread, h, moves, ratio);
                q += h * w;
                if !moves {
                    w = 0.0;
                }
            }
            let (gain, variance, left) = updated(spread, 1.0);
            spread = left;
            let innovation = value - q;
            q += gain[0] * innovation;
            w += gain[1] * innovation;
            if row >= SETTLING {
                squares += sample.weight * innovation * innovation / variance;
                logarithms += sample.weight * variance.ln();
                count += sample.weight;
            }
        }
    }
    (squares, logarithms, count)
}

/// The most likely noise behind the residuals of a model that fits; `least` is the variance that the steps of the sensor
/// alone have.
pub(super) fn likely(samples: &[Sample<'_>], least: f64) -> Noise {
    // Twice the negative log likelihood with the variance of the position concentrated out.
    let cost = |exponent: f64| {
        let (squares, logarithms, count) = surprise(samples, 10f64.powf(exponent));
        logarithms + count * (squares / count.max(1.0)).max(1e-300).ln()
    };
    let grid: Vec<f64> = (0..9).map(|step| 2.0 * f64::from(step)).collect();
    let costs: Vec<f64> = grid.iter().map(|&exponent| cost(exponent)).collect();
    let best = (0..grid.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0);
    let (mut low, mut high) = (grid[best] - 2.0, grid[best] + 2.0);
    let fraction = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..10 {
        let (a, b) = (high - fraction * (high - low), low + fraction * (high - low));
        if cost(a) < cost(b) {
            high = b;
        } else {
            low = a;
        }
    }
    let ratio = 10f64.powf(0.5 * (low + high));
    let (squares, _, count) = surprise(samples, ratio);
    let variance = (squares / count.max(1.0)).max(1e-30);
    Noise { position: variance.max(least), acceleration: ratio * variance }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use nalgebra::DMatrix;
    use rand::rngs::StdRng;
    use rand::{Rng, SeedableRng};
    use rand_distr::StandardNormal;

    use super::*;

    fn cells(rows: usize) -> Cells {
        let span_s = (1..rows).map(|row| if row % 7 == 0 { 1e-3 } else { 5e-4 }).collect();
        Cells { span_s, moves: vec![true; rows - 1] }
    }

    /// Position of white torque over the cells, drawn as its mean and its first moment.
    fn integrated(cells: &Cells, intensity: f64, rng: &mut StdRng) -> Vec<f64> {
        let (mut q, mut w) = (0.0, 0.0);
        let mut all = vec![0.0];
        for (&h, &moves) in cells.span_s.iter().zip(&cells.moves) {
            if moves {
                let (a, b): (f64, f64) = (rng.sample(StandardNormal), rng.sample(StandardNormal));
                q += h * w + (intensity * h * h * h).sqrt() * (0.5 * a + b / 12f64.sqrt());
                w += (intensity * h).sqrt() * a;
            } else {
                w = 0.0;
            }
            all.push(q);
        }
        all
    }

    #[test]
    fn filter_and_cholesky_factor_whiten_alike() {
        let cells = cells(40);
        let noise = Noise { position: 1e-11, acceleration: 2e-4 };
        let whitener = Whitener::new(&cells, noise);
        let mut filter = DMatrix::zeros(40, 40);
        for column in 0..40 {
            let mut unit = vec![0.0; 40];
            unit[column] = 1.0;
            whitener.apply(&cells, &mut unit);
            filter.set_column(column, &nalgebra::DVector::from_vec(unit));
        }
        // Covariance of twice integrated white noise: sum over cells of the overlap of their double integrals.
        let t: Vec<f64> = std::iter::once(0.0)
            .chain(cells.span_s.iter().scan(0.0, |t, h| {
                *t += h;
                Some(*t)
            }))
            .collect();
        let covariance = DMatrix::from_fn(40, 40, |i, j| {
            let (a, b) = (t[i].min(t[j]), t[i].max(t[j]));
            noise.acceleration * (a * a * (3.0 * b - a) / 6.0) + if i == j { noise.position } else { 0.0 }
        });
        let white = &filter * covariance * filter.transpose();
        assert!((white - DMatrix::identity(40, 40)).abs().max() < 1e-6);
    }

    #[test]
    fn the_noise_behind_residuals_is_found_through_estimated_starts_and_standstill() {
        let mut rng = StdRng::seed_from_u64(5);
        let truth = Noise { position: 1.4e-11, acceleration: 2.2e-4 };
        let mut still = cells(100);
        still.moves[30..].fill(false);
        let windows: Vec<(Cells, Vec<f64>)> = (0..120)
            .map(|index| {
                let cells = if index % 4 == 0 { still.clone() } else { cells(100) };
                let mut values = integrated(&cells, truth.acceleration, &mut rng);
                for (row, value) in values.iter_mut().enumerate() {
                    let deviate: f64 = rng.sample(StandardNormal);
                    *value += truth.position.sqrt() * deviate + 1e-3 - 0.3 * row as f64 * 1e-6;
                }
                (cells, values)
            })
            .collect();
        let samples: Vec<Sample<'_>> =
            windows.iter().map(|(cells, residual)| Sample { cells, residual, weight: 1.0 }).collect();
        let found = likely(&samples, 0.0);
        assert!((found.position / truth.position - 1.0).abs() < 0.1, "{found:?}");
        assert!((found.acceleration / truth.acceleration - 1.0).abs() < 0.2, "{found:?}");
    }
}
