//! The noise of a window: white noise of each sample, and white torque integrated twice from the window's start on.
//!
//! Covariance of the residuals q of a window: sigma^2 I + S G G', G the double integration over the actual sample times.
//! Its Cholesky factor is never formed: the innovations of a Kalman filter on (position, speed) that starts from a known
//! state are the same whitened residuals, in a time proportional to the rows.
//!
//! A rotor that rests takes no torque noise, but one that all but rests does, and creeps where the noise lifts it over its
//! hold. Which of the two is not seen in steps of the sensor; so the torque noise is taken to act always, which makes a
//! standstill weigh less than it might, and the noise is estimated where the rotor moves.

/// Noise of one recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Noise {
    /// Variance of a position sample, rad2 (m2).
    pub position: f64,
    /// Spectral density of the unexplained acceleration, (rad/s2)2 s.
    pub acceleration: f64,
}

/// Makes residuals of one window white, of unit variance.
#[derive(Debug, Clone)]
pub(super) struct Whitener {
    /// From the row before, s.
    spans_s: Vec<f64>,
    gains: Vec<[f64; 2]>,
    /// One over the standard deviation of each innovation.
    scales: Vec<f64>,
}

/// Covariance of position and speed: qq, qw, ww.
type Spread = [f64; 3];

/// What a cell adds to what is not known of position and speed.
fn ahead([qq, qw, ww]: Spread, h: f64, intensity: f64) -> Spread {
    let (qq, qw) = (qq + h * (2.0 * qw + h * ww), qw + h * ww);
    [qq + intensity * h * h * h / 3.0, qw + 0.5 * intensity * h * h, ww + intensity * h]
}

/// Gain of a sample, variance of its innovation, and what is left unknown.
fn updated([qq, qw, ww]: Spread, noise: f64) -> ([f64; 2], f64, Spread) {
    let variance = qq + noise;
    let gain = [qq / variance, qw / variance];
    (gain, variance, [qq * noise / variance, qw * noise / variance, ww - gain[1] * qw])
}

impl Whitener {
    /// Over rows at these times, from a start state that is exact.
    pub(super) fn new(t_s: &[f64], noise: Noise) -> Self {
        let rows = t_s.len();
        let (mut gains, mut scales) = (Vec::with_capacity(rows), Vec::with_capacity(rows));
        let spans_s: Vec<f64> = (0..rows).map(|row| t_s[row] - t_s[row.saturating_sub(1)]).collect();
        let mut spread = [0.0; 3];
        for &span_s in &spans_s {
            let (gain, variance, left) = updated(ahead(spread, span_s, noise.acceleration), noise.position);
            spread = left;
            gains.push(gain);
            scales.push(variance.sqrt().recip());
        }
        Self { spans_s, gains, scales }
    }

    /// Whitens in place.
    pub(super) fn apply(&self, values: &mut [f64]) {
        let (mut q, mut w) = (0.0, 0.0);
        for (row, value) in values.iter_mut().enumerate() {
            q += self.spans_s[row] * w;
            let (innovation, gain) = (*value - q, self.gains[row]);
            q += gain[0] * innovation;
            w += gain[1] * innovation;
            *value = innovation * self.scales[row];
        }
    }
}

/// Residuals of one window with its weight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample<'a> {
    /// Times of the rows, s.
    pub t_s: &'a [f64],
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
        let first_s = sample.t_s[1] - sample.t_s[0];
        let mut spread = [1e4, 0.0, 1e4 / (first_s * first_s)];
        let (mut q, mut w) = (0.0, 0.0);
        for (row, value) in sample.residual.iter().enumerate() {
            if row > 0 {
                let h = sample.t_s[row] - sample.t_s[row - 1];
                spread = ahead(spread, h, ratio);
                q += h * w;
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

    fn times(rows: usize) -> Vec<f64> {
        let spans_s = (0..rows).map(|row| if row % 7 == 0 { 1e-3 } else { 5e-4 });
        let sum = |t: &mut f64, h: f64| {
            *t += h;
            Some(*t)
        };
        spans_s.scan(0.0, sum).collect()
    }

    /// Position of white torque over the cells, drawn as its mean and its first moment.
    fn integrated(t_s: &[f64], intensity: f64, rng: &mut StdRng) -> Vec<f64> {
        let (mut q, mut w) = (0.0, 0.0);
        let mut all = vec![0.0];
        for pair in t_s.windows(2) {
            let h = pair[1] - pair[0];
            let (a, b): (f64, f64) = (rng.sample(StandardNormal), rng.sample(StandardNormal));
            q += h * w + (intensity * h * h * h).sqrt() * (0.5 * a + b / 12f64.sqrt());
            w += (intensity * h).sqrt() * a;
            all.push(q);
        }
        all
    }

    #[test]
    fn filter_and_cholesky_factor_whiten_alike() {
        let t_s = times(40);
        let noise = Noise { position: 1e-11, acceleration: 2e-4 };
        let whitener = Whitener::new(&t_s, noise);
        let mut filter = DMatrix::zeros(40, 40);
        for column in 0..40 {
            let mut unit = vec![0.0; 40];
            unit[column] = 1.0;
            whitener.apply(&mut unit);
            filter.set_column(column, &nalgebra::DVector::from_vec(unit));
        }
        // Covariance of twice integrated white noise: sum over cells of the overlap of their double integrals.
        let covariance = DMatrix::from_fn(40, 40, |i, j| {
            let (a, b) = (t_s[i].min(t_s[j]) - t_s[0], t_s[i].max(t_s[j]) - t_s[0]);
            noise.acceleration * (a * a * (3.0 * b - a) / 6.0) + if i == j { noise.position } else { 0.0 }
        });
        let white = &filter * covariance * filter.transpose();
        assert!((white - DMatrix::identity(40, 40)).abs().max() < 1e-6);
    }

    #[test]
    fn the_noise_behind_residuals_is_found_whatever_the_start_states() {
        let mut rng = StdRng::seed_from_u64(5);
        let truth = Noise { position: 1.4e-11, acceleration: 2.2e-4 };
        let t_s = times(100);
        let windows: Vec<Vec<f64>> = (0..120)
            .map(|_| {
                let mut values = integrated(&t_s, truth.acceleration, &mut rng);
                for (row, value) in values.iter_mut().enumerate() {
                    let deviate: f64 = rng.sample(StandardNormal);
                    *value += truth.position.sqrt() * deviate + 1e-3 - 0.3 * row as f64 * 1e-6;
                }
                values
            })
            .collect();
        let samples: Vec<Sample<'_>> =
            windows.iter().map(|residual| Sample { t_s: &t_s, residual, weight: 1.0 }).collect();
        let found = likely(&samples, 0.0);
        assert!((found.position / truth.position - 1.0).abs() < 0.1, "{found:?}");
        assert!((found.acceleration / truth.acceleration - 1.0).abs() < 0.2, "{found:?}");
    }
}
