//! What stands out of the residual: orders over position, frequencies over time, pushes. Start values for the fit.

use super::fit::Fit;
use super::problem::Problem;
use crate::effects::{Excitation, Physics, Pulse, Vibration};

/// Highest order per revolution that is looked for.
const MAX_ORDER: usize = 160;
/// Highest frequency that the narrowest bump lets pass, Hz.
const MAX_FREQUENCY_HZ: f64 = 110.0;
/// Candidates of each kind that are fitted.
const KEPT: usize = 4;

/// Residual of one width: recording, time, position, residual.
struct Point {
    recording: usize,
    t_s: f64,
    position: f64,
    value: f64,
}

fn points(problem: &Problem, residual: &[f64], width: usize) -> Vec<Point> {
    let rows = problem.equations[..problem.fitted_equations()]
        .iter()
        .zip(residual)
        .filter(|(equation, _)| equation.width == width);
    rows.map(|(equation, &value)| Point {
        recording: equation.recording,
        t_s: equation.row.centre_s,
        position: equation.row.mean(&problem.motions[equation.recording].cell_position),
        value,
    })
    .collect()
}

/// Sizes of the excitation and what stands out of the residual, N m (N).
pub(crate) fn excitation(problem: &Problem, physics: &Physics, residual: &[f64], linear: bool) -> Excitation {
    let peak = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |peak, v| peak.max(v.abs()));
    let motions = &problem.motions[..problem.fitted];
    let efforts = || motions.iter().flat_map(|m| m.effort.iter().copied());
    let count = efforts().count().max(1) as f64;
    let travel = problem.travel();
    let fine = points(problem, residual, 0);
    let field_peak = peak(&mut motions.iter().filter_map(|m| m.field.as_ref()).flatten().copied());
    let duration_s = motions.iter().map(|m| m.t_s[m.t_s.len() - 1] - m.t_s[0]).fold(0.0, f64::max);
    Excitation {
        torque_rms: (efforts().map(|u| u * u).sum::<f64>() / count).sqrt().max(1e-9),
        torque_peak: peak(&mut efforts()).max(1e-9) * physics.torque_gain,
        speed_peak: peak(&mut motions.iter().flat_map(|m| m.speed.iter().copied())),
        travel,
        field_peak,
        duration_s,
        period_s: motions.iter().map(|m| m.period_s).fold(0.0, f64::max),
        recordings: problem.motions.len(),
        linear,
        orders: orders(&fine, travel, linear),
        pulses: pulses(problem, residual),
        tones: tones(&fine, duration_s, problem.motions.len()),
    }
}

/// Orders over position that stand out of a residual, N m (N), best first.
pub(crate) fn orders_left(problem: &Problem, residual: &[f64], excitation: &Excitation) -> Vec<f64> {
    orders(&points(problem, residual, 0), excitation.travel, excitation.linear)
}

/// Orders that stand out of something given over position, best first.
pub(crate) fn orders_of(position: &[f64], values: &[f64], linear: bool) -> Vec<f64> {
    let stride = position.len().div_ceil(4000).max(1);
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let pairs = position.iter().zip(values).step_by(stride);
    let point = |(&position, &value): (&f64, &f64)| Point { recording: 0, t_s: 0.0, position, value: value - mean };
    let (low, high) = position.iter().fold((f64::MAX, f64::MIN), |(low, high), &q| (low.min(q), high.max(q)));
    orders(&pairs.map(point).collect::<Vec<_>>(), high - low, linear)
}

/// Share of the variance that a sine explains, by Lomb's normalisation.
fn power(points: &[Point], phase: impl Fn(&Point) -> f64) -> f64 {
    let (mut ss, mut cc, mut sc, mut ys, mut yc) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for point in points {
        let (sine, cosine) = phase(point).sin_cos();
        ss += sine * sine;
        cc += cosine * cosine;
        sc += sine * cosine;
        ys += point.value * sine;
        yc += point.value * cosine;
    }
    let determinant = ss * cc - sc * sc;
    if determinant <= 1e-9 * ss * cc { 0.0 } else { (ys * ys * cc + yc * yc * ss - 2.0 * ys * yc * sc) / determinant }
}

/// Local maxima of a spectrum, highest first.
fn peaks(grid: &[f64], spectrum: &[f64]) -> Vec<f64> {
    let at = |index: usize| spectrum.get(index).copied().unwrap_or(0.0);
    let mut tops: Vec<usize> =
        (0..grid.len()).filter(|&i| at(i) > 0.0 && at(i) >= at(i + 1) && (i == 0 || at(i) >= at(i - 1))).collect();
    tops.sort_by(|&a, &b| spectrum[b].total_cmp(&spectrum[a]));
    tops.iter().take(KEPT).map(|&index| grid[index]).collect()
}

fn orders(points: &[Point], travel: f64, linear: bool) -> Vec<f64> {
    if points.len() < 20 || travel <= 0.0 {
        return Vec::new();
    }
    // On a linear axis there is no revolution: periods from the whole travel down.
    let grid: Vec<f64> = if linear {
        (0..MAX_ORDER).map(|k| std::f64::consts::TAU / travel * 2.0 * 1.03f64.powi(k as i32)).collect()
    } else {
        // An order that turns less than half a period over the travel is a slope.
        (1..=MAX_ORDER).map(|order| order as f64).filter(|order| order * travel > 3.0).collect()
    };
    let spectrum: Vec<f64> = grid.iter().map(|&order| power(points, |point| order * point.position)).collect();
    peaks(&grid, &spectrum)
}

/// Tones with what each recording to fit has of them: from another phase the first step would change the frequency too much.
fn tones(points: &[Point], duration_s: f64, recordings: usize) -> Vec<Vibration> {
    if points.len() < 20 {
        return Vec::new();
    }
    let step_hz = 0.5 / duration_s.clamp(0.5, 20.0);
    let count = (MAX_FREQUENCY_HZ / step_hz) as usize;
    let grid: Vec<f64> = (2..count).map(|k| k as f64 * step_hz).collect();
    let of_recording = |recording: usize| -> Vec<&Point> {
        let from = points.partition_point(|point| point.recording < recording);
        let to = points.partition_point(|point| point.recording <= recording);
        points[from..to].iter().step_by((to - from).div_ceil(4000).max(1)).collect()
    };
    let parts: Vec<Vec<&Point>> = (0..recordings).map(of_recording).collect();
    let power = |hz: f64| {
        let powers = parts.iter().map(|part| {
            let (sine, cosine) = phasor(part, hz);
            0.5 * part.len() as f64 * (sine * sine + cosine * cosine)
        });
        powers.sum::<f64>()
    };
    let spectrum: Vec<f64> = grid.iter().map(|&hz| power(hz)).collect();
    let tone = |frequency_hz: f64| Vibration {
        frequency_hz,
        phasors: parts.iter().map(|part| phasor(part, frequency_hz)).collect(),
    };
    peaks(&grid, &spectrum).into_iter().map(tone).collect()
}

/// Amplitudes of sine and cosine at one frequency; the sums of squares are half the count closely enough to rank.
fn phasor(points: &[&Point], frequency_hz: f64) -> (f64, f64) {
    let (mut sine_sum, mut cosine_sum) = (0.0, 0.0);
    for point in points {
        let (sine, cosine) = (std::f64::consts::TAU * frequency_hz * point.t_s).sin_cos();
        sine_sum += point.value * sine;
        cosine_sum += point.value * cosine;
    }
    let share = 2.0 / points.len().max(1) as f64;
    (share * sine_sum, share * cosine_sum)
}

/// How much more than any other span of its recording a push must explain, in what is left once it is known.
const STANDS_OUT: f64 = 3.0;
/// Longest push, in points of half the bump's width.
const LONGEST: usize = 120;
/// Bumps whose residuals show pushes.
const PULSE_WIDTH: usize = 0;

/// Residual over time of one recording, narrow bumps.
fn over_time(problem: &Problem, residual: impl Fn(usize) -> f64, recording: usize) -> Vec<(f64, f64)> {
    let rows = problem.equations.iter().enumerate();
    rows.filter(|(_, equation)| equation.recording == recording && equation.width == PULSE_WIDTH)
        .map(|(index, equation)| (equation.row.centre_s, residual(index)))
        .collect()
}

/// In each recording the span whose mean stands out most.
fn pulses(problem: &Problem, residual: &[f64]) -> Vec<Pulse> {
    let mut all = Vec::new();
    for recording in 0..problem.fitted {
        let points = over_time(problem, |index| residual[index], recording);
        let Some((_, from, to)) = best_span(&points) else { continue };
        let mean = points[from..=to].iter().map(|point| point.1).sum::<f64>() / (to - from + 1) as f64;
        let (start_s, end_s) = (points[from].0 - 0.002, points[to].0 + 0.002);
        // The residual is inertia times acceleration minus what is known: a push is its sum.
        all.push(Pulse { recording, start_s, duration_s: end_s - start_s, amplitude: mean });
    }
    all
}

/// How many spans of all recordings are compared.
pub(crate) fn spans(problem: &Problem) -> usize {
    LONGEST * problem.equations.iter().filter(|equation| equation.width == PULSE_WIDTH).count()
}

/// Whether the last effect of `fit`, a push, is an event: in its recording nothing left over comes near to it.
pub(crate) fn stands_out(problem: &Problem, base: &Fit, fit: &Fit) -> bool {
    let Some(&recording) = fit.active.last().and_then(|entry| entry.values.first()) else { return false };
    let score = |residual: &nalgebra::DVector<f64>| {
        best_span(&over_time(problem, |index| residual[index], recording as usize)).map_or(0.0, |best| best.0)
    };
    score(&base.residual) > STANDS_OUT * score(&fit.residual)
}

/// The span with the largest square of its sum over its length: score, first and last point.
fn best_span(points: &[(f64, f64)]) -> Option<(f64, usize, usize)> {
    let mut best: Option<(f64, usize, usize)> = None;
    for from in 0..points.len() {
        let mut sum = 0.0;
        for (to, point) in points.iter().enumerate().skip(from).take(LONGEST) {
            sum += point.1;
            let score = sum * sum / (to - from + 1) as f64;
            if best.is_none_or(|(top, _, _)| score > top) {
                best = Some((score, from, to));
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_tone_begins_with_its_phase_in_each_recording() {
        let shaken = [(0.3, -0.1), (0.0, 0.2)];
        let point = |recording: usize, number: u32| {
            let t_s = 0.004 * f64::from(number);
            let (sine, cosine) = (std::f64::consts::TAU * 32.8 * t_s).sin_cos();
            let (s, c) = shaken[recording];
            Point { recording, t_s, position: 0.0, value: s * sine + c * cosine }
        };
        let points: Vec<Point> = (0..2).flat_map(|recording| (0..2000).map(move |n| point(recording, n))).collect();
        let first = tones(&points, 8.0, 3).remove(0);
        assert!((first.frequency_hz - 32.8).abs() < 0.07);
        assert_eq!(first.phasors[2], (0.0, 0.0));
        for ((sine, cosine), (s, c)) in first.phasors.into_iter().zip(shaken) {
            let along = (sine * s + cosine * c) / (s.hypot(c) * sine.hypot(cosine));
            assert!(along > 0.5, "{sine} {cosine}");
        }
    }
}
