//! Short windows of the model against the recording.

use nalgebra::{Matrix2, Vector2};
use plant::{Command, Mechanics, Model, State, Timeline};
use rayon::prelude::*;

use super::commands::recorded_commands;
use crate::Error;
use crate::read::Recording;

/// Gauss-Newton passes over the start state. It enters almost linearly, so that two reach the sensor's noise; the third is
/// for windows that stick.
const PASSES: usize = 3;

/// What one window left.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// First row.
    pub start: usize,
    /// One past the last row.
    pub end: usize,
    /// Estimated position and speed at the first row.
    pub state: State,
    /// Recorded minus simulated position, one a row, rad (m).
    pub residual: Vec<f64>,
    /// The constant torque that would explain most of it, N m (N): inertia times the residual's curvature.
    pub torque: f64,
    /// Mean speed over the window, rad/s (m/s).
    pub speed: f64,
}

/// The residual of a whole recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Residual {
    /// Length of the windows, s.
    pub horizon_s: f64,
    /// Back to back, in order; none across a gap.
    pub windows: Vec<Window>,
}

impl Residual {
    /// Root mean square over all rows, rad (m).
    pub fn rms(&self) -> f64 {
        let (sum, rows) = self.windows.iter().fold((0.0, 0), |(sum, rows), window| {
            (sum + window.residual.iter().map(|r| r * r).sum::<f64>(), rows + window.residual.len())
        });
        (sum / f64::from(rows.max(1) as u32)).sqrt()
    }
}

/// Runs `model` over `recording` in windows of `horizon_s`, each from its best start state.
///
/// # Errors
/// A recording too short for one window, or a model the plant refuses.
pub fn residual(model: &Model, recording: &Recording, horizon_s: f64) -> Result<Residual, Error> {
    let unusable = |error: plant::Error| Error::Usage(format!("{}: {error}", recording.name));
    let commands = recorded_commands(recording);
    // A recording cut from the middle was driven before its first row; its first command is the best guess.
    let before = commands.first().copied().unwrap_or_default();
    let before = Command { speed_estimate: 0.0, ..before };
    let timeline = Timeline::new(model, &recording.t_s, &commands, &before).map_err(unusable)?;
    let mechanics = Mechanics::new(model).map_err(unusable)?;
    let spans = spans(recording, horizon_s);
    if spans.is_empty() {
        let length_s = recording.t_s.last().unwrap_or(&0.0) - recording.t_s.first().unwrap_or(&0.0);
        return Err(Error::Usage(format!(
            "{}: {length_s:.3} s without a window of {horizon_s} s between gaps; record longer",
            recording.name
        )));
    }
    let fit = Fit { mechanics: &mechanics, timeline: &timeline, recording, inertia: model.inertia };
    let windows = spans.into_par_iter().map(|(start, end)| fit.window(start, end)).collect::<Result<_, _>>();
    Ok(Residual { horizon_s, windows: windows.map_err(unusable)? })
}

/// Rows of back-to-back windows; a window that would cross a gap, or hold fewer than eight rows, is left out.
fn spans(recording: &Recording, horizon_s: f64) -> Vec<(usize, usize)> {
    let t_s = &recording.t_s;
    let mut spans = Vec::new();
    let mut start = 0;
    while start < t_s.len() {
        let in_time = t_s[start..].partition_point(|t| *t < t_s[start] + horizon_s) + start;
        let gap = recording.gaps.partition_point(|gap| *gap < start);
        let to_gap = recording.gaps.get(gap).map_or(t_s.len(), |gap| gap + 1);
        let end = in_time.min(to_gap);
        let covers = end < t_s.len() && t_s[end.min(t_s.len() - 1)] >= t_s[start] + horizon_s && end == in_time;
        if covers && end - start >= 8 {
            spans.push((start, end));
        }
        start = end.max(start + 1);
    }
    spans
}

struct Fit<'a> {
    mechanics: &'a Mechanics,
    timeline: &'a Timeline,
    recording: &'a Recording,
    inertia: f64,
}

impl Fit<'_> {
    fn window(&self, start: usize, end: usize) -> Result<Window, plant::Error> {
        let (t_s, measured) = (&self.recording.t_s[start..end], &self.recording.position[start..end]);
        let mut simulated = vec![0.0; t_s.len()];
        let (first, slope) = line(t_s, measured);
        // From the mean motion, and from rest: a model that sticks has no slope to follow from one to the other.
        let mut best: Option<(f64, State)> = None;
        for guess in [(first, slope), (measured.iter().sum::<f64>() / measured.len() as f64, 0.0)] {
            let (cost, state) = self.descend(guess, t_s, measured, &mut simulated)?;
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, state));
            }
        }
        let state = best.map_or_else(State::default, |(_, state)| state);
        self.mechanics.simulate(self.timeline, t_s[0], state, t_s, &mut simulated)?;
        let residual: Vec<f64> = measured.iter().zip(&simulated).map(|(m, s)| m - s).collect();
        let torque = self.inertia * curvature(t_s, &residual);
        Ok(Window { start, end, state, residual, torque, speed: slope })
    }

    /// Damped Gauss-Newton over start position and speed; returns the least sum of squares and its state.
    fn descend(
        &self,
        guess: (f64, f64),
        t_s: &[f64],
        measured: &[f64],
        simulated: &mut [f64],
    ) -> Result<(f64, State), plant::Error> {
        let span_s = t_s[t_s.len() - 1] - t_s[0];
        let mut at = Vector2::new(guess.0, guess.1);
        let mut cost = self.cost(at, t_s, measured, simulated)?;
        let mut faster = vec![0.0; t_s.len()];
        for _ in 0..PASSES {
            // A speed step that moves the end by about a thousandth of a typical window's travel.
            let step = 1e-3 * at[1].abs().max(1e-6 / span_s);
            self.run(Vector2::new(at[0], at[1] + step), t_s, &mut faster)?;
            let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
            for ((m, s), f) in measured.iter().zip(simulated.iter()).zip(&faster) {
                let row = Vector2::new(1.0, (f - s) / step);
                normal += row * row.transpose();
                right += row * (m - s);
            }
            let Some(inverse) = (normal + Matrix2::from_diagonal(&(normal.diagonal() * 1e-9))).try_inverse() else {
                break;
            };
            let next = at + inverse * right;
            let next_cost = self.cost(next, t_s, measured, simulated)?;
            if next_cost.is_nan() || next_cost >= cost {
                break;
            }
            (at, cost) = (next, next_cost);
        }
        Ok((cost, State::new(at[0], at[1])))
    }

    fn run(&self, at: Vector2<f64>, t_s: &[f64], positions: &mut [f64]) -> Result<(), plant::Error> {
        self.mechanics.simulate(self.timeline, t_s[0], State::new(at[0], at[1]), t_s, positions).map(|_| ())
    }

    fn cost(&self, at: Vector2<f64>, t_s: &[f64], measured: &[f64], out: &mut [f64]) -> Result<f64, plant::Error> {
        self.run(at, t_s, out)?;
        Ok(measured.iter().zip(out.iter()).map(|(m, s)| (m - s) * (m - s)).sum())
    }
}

/// Value at the first time and slope of the least-squares line.
fn line(t_s: &[f64], values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let (mean_t, mean) = (t_s.iter().sum::<f64>() / count, values.iter().sum::<f64>() / count);
    let (mut products, mut squares) = (0.0, 0.0);
    for (t, value) in t_s.iter().zip(values) {
        products += (t - mean_t) * (value - mean);
        squares += (t - mean_t) * (t - mean_t);
    }
    let slope = if squares > 0.0 { products / squares } else { 0.0 };
    (mean + slope * (t_s[0] - mean_t), slope)
}

/// Second derivative of the least-squares parabola: the projection on the part of t^2/2 that a line cannot follow.
fn curvature(t_s: &[f64], values: &[f64]) -> f64 {
    let half_squares: Vec<f64> = t_s.iter().map(|t| 0.5 * (t - t_s[0]) * (t - t_s[0])).collect();
    let (first, slope) = line(t_s, &half_squares);
    let (mut products, mut squares) = (0.0, 0.0);
    for ((t, value), half) in t_s.iter().zip(values).zip(&half_squares) {
        let bend = half - first - slope * (t - t_s[0]);
        products += bend * value;
        squares += bend * bend;
    }
    if squares > 0.0 { products / squares } else { 0.0 }
}
