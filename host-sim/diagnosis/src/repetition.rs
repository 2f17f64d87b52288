//! Motions that repeat themselves: what depends on the state then repeats with them and looks like a tone.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use crate::recorded::Recorded;

/// Correlation of a motion with itself one period later, from which it repeats: the share of its squares that does not repeat is then
/// less than half. Of real machines, robots on a program have 0.86 to 1.00, excitation made to tell something 0.0 to 0.7.
const REPEATS: f64 = 0.8;
/// Harmonics that what depends on the state may have: those of dry friction, a square wave, fall with their number, in power below a
/// hundredth of the first from the tenth on.
const HARMONICS: f64 = 10.0;

/// A motion that repeats itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Repetition {
    period_s: f64,
    duration_s: f64,
}

impl Repetition {
    /// How the motion of a recording repeats itself at least twice; none where it does not.
    pub fn of(recorded: &Recorded) -> Option<Self> {
        let correlation = correlation(&recorded.position);
        let half = &correlation[..correlation.len() / 2];
        // Every motion is like itself a little later.
        let other = half.iter().position(|value| *value < 0.0)?;
        let (rows, value) = half.iter().enumerate().skip(other).max_by(|a, b| a.1.total_cmp(b.1))?;
        let duration_s = recorded.duration_s();
        let period_s = rows as f64 * duration_s / (recorded.rows() - 1) as f64;
        (*value >= REPEATS).then_some(Self { period_s, duration_s })
    }

    /// Whether a tone cannot be told from a harmonic of the motion within the recording.
    pub fn has_harmonic(&self, frequency_hz: f64) -> bool {
        let harmonic = (frequency_hz * self.period_s).round();
        harmonic <= HARMONICS && (frequency_hz - harmonic / self.period_s).abs() * self.duration_s < 1.0
    }
}

/// Correlation of what a straight line leaves of values with itself so many rows later, -1 to 1.
fn correlation(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let left = without_line(values);
    let length = (2 * n).next_power_of_two();
    let mut planner = FftPlanner::new();
    let mut spectrum: Vec<Complex<f64>> = left.iter().map(|value| Complex::new(*value, 0.0)).collect();
    spectrum.resize(length, Complex::new(0.0, 0.0));
    planner.plan_fft_forward(length).process(&mut spectrum);
    spectrum.iter_mut().for_each(|value| *value = Complex::new(value.norm_sqr() / length as f64, 0.0));
    planner.plan_fft_inverse(length).process(&mut spectrum);
    let mut sums = vec![0.0];
    for value in &left {
        sums.push(sums[sums.len() - 1] + value * value);
    }
    // Over as many squares as both have in common.
    let common = |lag: usize| (sums[n - lag] * (sums[n] - sums[lag])).sqrt().max(f64::MIN_POSITIVE);
    (0..n).map(|lag| spectrum[lag].re / common(lag)).collect()
}

/// What the straight line through values by least squares leaves of them.
fn without_line(values: &[f64]) -> Vec<f64> {
    let n = values.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = values.iter().sum::<f64>() / n.max(1.0);
    let of = |row: usize| row as f64 - middle;
    let squares: f64 = (0..values.len()).map(|row| of(row).powi(2)).sum();
    let slope = values.iter().enumerate().map(|(row, value)| of(row) * value).sum::<f64>() / squares.max(1.0);
    values.iter().enumerate().map(|(row, value)| value - mean - slope * of(row)).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use recording::{AxisKind, Recording};

    use super::*;

    fn recorded(position: impl Fn(f64) -> f64) -> Recorded {
        let t_s: Vec<f64> = (0..2000).map(|row| 0.01 * f64::from(row)).collect();
        let position: Vec<f64> = t_s.iter().map(|t| position(*t)).collect();
        let effort_cmd = vec![0.0; t_s.len()];
        Recorded::new(&Recording { t_s, position, effort_cmd, ..Recording::empty(AxisKind::Rotary) })
    }

    #[test]
    fn a_program_repeats_and_a_sweep_does_not() {
        let program = Repetition::of(&recorded(|t| 0.1 * t + (1.25 * t).sin().clamp(-0.5, 0.5))).unwrap();
        let period_s = std::f64::consts::TAU / 1.25;
        assert!((program.period_s - period_s).abs() < 0.02, "{program:?}");
        assert!(program.has_harmonic(3.0 / period_s) && program.has_harmonic(3.1 / period_s));
        assert!(!program.has_harmonic(3.5 / period_s) && !program.has_harmonic(12.0 / period_s));
        assert_eq!(Repetition::of(&recorded(|t| (t * (1.0 + 0.3 * t)).sin())), None);
        assert_eq!(Repetition::of(&recorded(|t| 2.0 * t)), None, "nothing that moves one way repeats");
    }
}
