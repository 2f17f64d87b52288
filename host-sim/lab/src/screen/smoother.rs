//! Fixed-interval smoother of the motion: position, speed, and the acceleration that the commands do not explain.
//!
//! State q, w, d with q' = w, w' = u + d and d a random walk; u is known. Kalman filter forward, Rauch-Tung-Striebel
//! backward. The intensity of d is the one that makes the innovations most likely, with the variance of the position
//! concentrated out, so that it needs no setting for any resolution.

use nalgebra::{Matrix3, RowVector3, Vector3};

/// Estimates at the samples.
#[derive(Debug, Clone)]
pub(crate) struct Smoothed {
    /// rad (m).
    pub position: Vec<f64>,
    /// rad/s (m/s).
    pub speed: Vec<f64>,
    /// Standard deviation of the speed.
    pub speed_deviation: Vec<f64>,
    /// Standard deviation of the position samples, rad (m).
    pub noise: f64,
}

struct Pass {
    mean: Vec<Vector3<f64>>,
    covariance: Vec<Matrix3<f64>>,
    /// Twice the negative log likelihood, up to a constant.
    surprise: f64,
    variance: f64,
}

fn transition(span_s: f64) -> Matrix3<f64> {
    Matrix3::new(1.0, span_s, 0.5 * span_s * span_s, 0.0, 1.0, span_s, 0.0, 0.0, 1.0)
}

fn spread(span_s: f64, intensity: f64) -> Matrix3<f64> {
    let h = span_s;
    let (h2, h3) = (h * h, h * h * h);
    intensity
        * Matrix3::new(
            h3 * h2 / 20.0,
            h2 * h2 / 8.0,
            h3 / 6.0,
            h2 * h2 / 8.0,
            h3 / 3.0,
            h2 / 2.0,
            h3 / 6.0,
            h2 / 2.0,
            h,
        )
}

fn drift(span_s: f64, acceleration: f64) -> Vector3<f64> {
    Vector3::new(0.5 * span_s * span_s * acceleration, span_s * acceleration, 0.0)
}

/// Forward pass with unit position variance; `ratio` is the intensity of d over that variance.
fn forward(t_s: &[f64], position: &[f64], known: &[f64], ratio: f64, keep: bool) -> Pass {
    let period_s = (t_s[t_s.len() - 1] - t_s[0]) / (t_s.len() - 1) as f64;
    let mut mean = Vector3::new(position[0], 0.0, 0.0);
    let wide = 1.0 / (period_s * period_s);
    let mut covariance = Matrix3::from_diagonal(&Vector3::new(1.0, 1e4 * wide, ratio.max(1.0) * 10.0));
    let mut pass = Pass { mean: Vec::new(), covariance: Vec::new(), surprise: 0.0, variance: 0.0 };
    if keep {
        pass.mean.push(mean);
        pass.covariance.push(covariance);
    }
    let (mut squares, mut logarithms) = (0.0, 0.0);
    for index in 1..t_s.len() {
        let span_s = t_s[index] - t_s[index - 1];
        let step = transition(span_s);
        mean = step * mean + drift(span_s, known[index - 1]);
        covariance = step * covariance * step.transpose() + spread(span_s, ratio);
        let innovation = position[index] - mean[0];
        let variance = covariance[(0, 0)] + 1.0;
        let gain = covariance.column(0) / variance;
        mean += gain * innovation;
        let row: RowVector3<f64> = covariance.row(0).into_owned();
        covariance -= gain * row;
        // The first samples only find the state.
        if index > 5 {
            squares += innovation * innovation / variance;
            logarithms += variance.ln();
        }
        if keep {
            pass.mean.push(mean);
            pass.covariance.push(covariance);
        }
    }
    let count = t_s.len().saturating_sub(6).max(1) as f64;
    pass.variance = (squares / count).max(1e-30);
    pass.surprise = logarithms + count * pass.variance.ln();
    pass
}

/// The most likely ratio, by golden section over its logarithm.
fn likely_ratio(t_s: &[f64], position: &[f64], known: &[f64]) -> f64 {
    let surprise = |exponent: f64| forward(t_s, position, known, 10f64.powf(exponent), false).surprise;
    let grid: Vec<f64> = (0..9).map(|step| 4.0 + 2.0 * f64::from(step)).collect();
    let values: Vec<f64> = grid.iter().map(|&exponent| surprise(exponent)).collect();
    let best = (0..grid.len()).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
    let (mut low, mut high) = (grid[best] - 2.0, grid[best] + 2.0);
    let fraction = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..6 {
        let (a, b) = (high - fraction * (high - low), low + fraction * (high - low));
        if surprise(a) < surprise(b) {
            high = b;
        } else {
            low = a;
        }
    }
    10f64.powf(0.5 * (low + high))
}

/// Smooths a position; `known` is the known acceleration of each cell.
pub(crate) fn smooth(t_s: &[f64], position: &[f64], known: &[f64], resolution: f64) -> Smoothed {
    // The likelihood of the ratio needs no more than some seconds of data.
    let part = t_s.len().min(20_000);
    let ratio = likely_ratio(&t_s[..part], &position[..part], &known[..part.saturating_sub(1)]);
    let pass = forward(t_s, position, known, ratio, true);
    let variance = pass.variance.max(resolution * resolution / 120.0);
    let count = t_s.len();
    let (mut mean, mut covariance) = (pass.mean[count - 1], pass.covariance[count - 1]);
    let mut out = Smoothed {
        position: vec![0.0; count],
        speed: vec![0.0; count],
        speed_deviation: vec![0.0; count],
        noise: variance.sqrt(),
    };
    for index in (0..count).rev() {
        if index + 1 < count {
            let span_s = t_s[index + 1] - t_s[index];
            let step = transition(span_s);
            let ahead = step * pass.covariance[index] * step.transpose() + spread(span_s, ratio);
            if let Some(inverse) = ahead.try_inverse() {
                let gain = pass.covariance[index] * step.transpose() * inverse;
                let predicted = step * pass.mean[index] + drift(span_s, known[index]);
                mean = pass.mean[index] + gain * (mean - predicted);
                covariance = pass.covariance[index] + gain * (covariance - ahead) * gain.transpose();
            } else {
                (mean, covariance) = (pass.mean[index], pass.covariance[index]);
            }
        }
        out.position[index] = mean[0];
        out.speed[index] = mean[1];
        out.speed_deviation[index] = (covariance[(1, 1)].max(0.0) * variance).sqrt();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speed_of_a_coarsely_quantised_sine_is_found_within_its_own_deviation() {
        let t_s: Vec<f64> = (0..4000).map(|row| f64::from(row) * 5e-4).collect();
        let step = 1.534e-3;
        let omega = std::f64::consts::TAU;
        let position: Vec<f64> = t_s.iter().map(|t| ((omega * t).sin() / step).round() * step).collect();
        let out = smooth(&t_s, &position, &vec![0.0; t_s.len() - 1], step);
        let mut worst: f64 = 0.0;
        for (t, speed) in t_s.iter().zip(&out.speed).skip(200).take(3600) {
            worst = worst.max((speed - omega * (omega * t).cos()).abs());
        }
        assert!(worst < 0.08, "{worst} rad/s");
        assert!((0.1..3.0).contains(&(out.noise / step)), "{}", out.noise);
    }
}
