//! Short windows of the model against the recording.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use diagnosis::recorded::commands;
use plant::{Command, Mechanics, Model, State, Timeline};
use rayon::prelude::*;

use super::gaps::unsettled;
use super::start_state::{StartState, curvature, line, speed_at};
use super::unknowns::Unknowns;
use crate::Error;
use crate::progress::Progress;
use crate::read::Recording;

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

/// A window is far out where its torque is beyond this many times the median,
const FAR_OUT: f64 = 10.0;
/// and such windows are no more than this share of all: more of them are what the machine does.
const FEW: f64 = 0.05;

impl Residual {
    /// The torque, N m (N), beyond which windows are set aside from the shares that channels explain: a few windows far
    /// beyond all others (a crash, a push, a rewind before the run) hold most of the squares and would hide the rest. They
    /// stay in every other figure. Infinite where no window, or more than a few, are so far out.
    pub fn set_aside_beyond(&self) -> f64 {
        let mut sizes: Vec<f64> = self.windows.iter().map(|window| window.torque.abs()).collect();
        if sizes.is_empty() {
            return f64::INFINITY;
        }
        let middle = sizes.len() / 2;
        let limit = FAR_OUT * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
        let beyond = sizes.iter().filter(|size| **size > limit).count();
        if beyond as f64 > FEW * sizes.len() as f64 { f64::INFINITY } else { limit }
    }

    /// The windows that are not set aside.
    pub fn usual(&self) -> impl Iterator<Item = &Window> {
        let limit = self.set_aside_beyond();
        self.windows.iter().filter(move |window| window.torque.abs() <= limit)
    }
}

/// Rows that a window has at least, whatever the sampling: two of them go into its start state.
const LEAST_ROWS: f64 = 10.0;

/// Length of the windows of a recording, s: as wished, or as long as enough rows take.
fn horizon_s(recording: &Recording, wished_s: f64) -> f64 {
    // Whole microseconds: the last digits of jittered times are no part of a length that is told.
    wished_s.max((1e6 * LEAST_ROWS * median_period_s(&recording.t_s)).round() / 1e6)
}

/// Median time from row to row, s; 1 ms without two rows.
fn median_period_s(t_s: &[f64]) -> f64 {
    let mut spans: Vec<f64> = t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    spans.sort_by(f64::total_cmp);
    spans.get(spans.len() / 2).copied().unwrap_or(1e-3)
}

/// Work of the plant, as it counts it, that a residual may take: this, seven seconds at the 0.13 us of the slowest law that was
/// measured (a cogging that swings the rotor in less than a step), twice that beside other work ...
const LEAST_BUDGET: u64 = 50_000_000;
/// ... with so much a row, several times what a fluid with a bristle of 1e9 N m/rad needs on rows of 5 ms (75,000) ...
const STIFF_ROW: u64 = 500_000;
/// ... up to this, which 15 s of such a fluid, or of a load in its gap at 10 kHz, do not reach (220 and 250 million): a comparison
/// has two residuals, and so ends within the minute, refused or not ...
const MOST_BUDGET: u64 = 260_000_000;
/// ... and for each row many times what a plain machine takes, or a log of hours had no comparison.
const PLAIN_ROW: u64 = 500;

/// The work that a residual of so many rows may take.
fn budget(rows: usize) -> u64 {
    let rows = rows as u64;
    (LEAST_BUDGET + STIFF_ROW * rows).min(MOST_BUDGET) + PLAIN_ROW * rows
}

/// In words, why a recording has no window of that length, s.
fn no_window(recording: &Recording, horizon_s: f64) -> String {
    let name = &recording.name;
    let length_s = recording.t_s.last().unwrap_or(&0.0) - recording.t_s.first().unwrap_or(&0.0);
    let window = format!("a window of {} rows takes {horizon_s:.3} s", LEAST_ROWS);
    if length_s < 3.0 * horizon_s || recording.gaps.is_empty() {
        return format!("{name}: {length_s:.3} s long, and {window}; record at least {:.1} s", 40.0 * horizon_s);
    }
    let gaps = recording.gaps.len();
    format!("{name}: {gaps} gaps, no two of which are far enough apart: {window}; record without losing rows")
}

/// Runs `model` over `recording` in windows of `horizon_s`, or of ten rows where those are longer, each from its best start state,
/// bristles and load included.
///
/// # Errors
/// A recording too short for one window, or a model the plant refuses.
pub fn residual(model: &Model, recording: &Recording, horizon_s: f64) -> Result<Residual, Error> {
    let unusable = |error: plant::Error| Error::Usage(format!("{}: {error}", recording.name));
    let commands = commands(recording);
    // A recording cut from the middle was driven before its first row; its first command is the best guess.
    let before = commands.first().copied().unwrap_or_default();
    let before = Command { speed_estimate: 0.0, ..before };
    let timeline = Timeline::new(model, &recording.t_s, &commands, &before).map_err(unusable)?;
    let (work, most) = (Arc::new(AtomicU64::new(0)), budget(recording.rows()));
    let mechanics = Mechanics::new(model).map_err(unusable)?.counting(&work).at_most(most);
    let horizon_s = self::horizon_s(recording, horizon_s);
    let spans = spans(recording, horizon_s);
    if spans.is_empty() {
        return Err(Error::Usage(no_window(recording, horizon_s)));
    }
    let fit = Fit { mechanics: &mechanics, timeline: &timeline, recording, model };
    let what = format!("{}, windows of {:.0} ms", recording.name, 1e3 * horizon_s);
    let progress = Progress::new(&what, spans.len() as u64);
    let window = |(start, end)| fit.window(start, end).inspect(|_| progress.advance(1));
    let windows = spans.into_par_iter().map(window).collect::<Result<Vec<Window>, _>>().map_err(unusable)?;
    if windows.iter().any(|window| !window.torque.is_finite() || window.residual.iter().any(|left| !left.is_finite())) {
        let name = &recording.name;
        return Err(Error::Usage(format!(
            "{name}: the model of the machine file leaves positions that are no numbers; check its inertia, friction and delays"
        )));
    }
    Ok(Residual { horizon_s, windows })
}

/// Rows of back-to-back windows; a window that would cross a gap, hold fewer than eight rows, or begin where commands lost in
/// a gap still act, is left out.
fn spans(recording: &Recording, horizon_s: f64) -> Vec<(usize, usize)> {
    let t_s = &recording.t_s;
    let unsettled = unsettled(recording);
    let mut spans = Vec::new();
    let mut start = 0;
    while start < t_s.len() {
        if unsettled[start] {
            start += 1;
            continue;
        }
        // A row that only rounding puts before the end belongs to the next window.
        let until_s = t_s[start] + horizon_s * (1.0 - 1e-9);
        let in_time = t_s[start..].partition_point(|t| *t < until_s) + start;
        let gap = recording.gaps.partition_point(|gap| *gap < start);
        let to_gap = recording.gaps.get(gap).map_or(t_s.len(), |gap| gap + 1);
        let end = in_time.min(to_gap);
        // The row at its end shows that the window is whole.
        if in_time < to_gap && end - start >= 8 {
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
    model: &'a Model,
}

impl Fit<'_> {
    fn window(&self, start: usize, end: usize) -> Result<Window, plant::Error> {
        let (t_s, position) = (&self.recording.t_s, &self.recording.position);
        // The rows before the window tell its first speed too, back to the last gap.
        let gap = self.recording.gaps.partition_point(|gap| *gap < start);
        let after_gap = gap.checked_sub(1).map_or(0, |gap| self.recording.gaps[gap] + 1);
        let speed_guess = speed_at(t_s, position, start, after_gap, end);
        let (t_s, measured) = (&t_s[start..end], &position[start..end]);
        let window = StartState {
            mechanics: self.mechanics,
            timeline: self.timeline,
            t_s,
            measured,
            unknowns: Unknowns::of(self.model),
        };
        let (state, simulated) = window.estimate(speed_guess)?;
        let residual: Vec<f64> = measured.iter().zip(&simulated).map(|(m, s)| m - s).collect();
        let torque = self.model.inertia * curvature(t_s, &residual);
        Ok(Window { start, end, state, residual, torque, speed: line(t_s, measured).1 })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::residual::testing::{self, recording};

    fn regular(rows: u32) -> Recording {
        let t_s: Vec<f64> = (0..rows).map(|row| f64::from(row) / 1000.0).collect();
        recording(t_s.clone(), t_s)
    }

    #[test]
    fn windows_are_back_to_back_and_whole() {
        let spans = spans(&regular(101), 0.02);
        assert_eq!(spans, [(0, 20), (20, 40), (40, 60), (60, 80), (80, 100)]);
        // The last window needs the row at its end, or it would be shorter than the others.
        assert_eq!(super::spans(&regular(100), 0.02).len(), 4);
        assert_eq!(super::spans(&regular(5), 0.02), []);
        assert_eq!(super::spans(&regular(100), 0.005), [], "fewer than eight rows tell nothing");
    }

    #[test]
    fn no_window_crosses_a_gap_and_they_begin_anew_behind_it() {
        let mut torn = regular(101);
        torn.t_s.iter_mut().skip(50).for_each(|t_s| *t_s += 0.007);
        torn.gaps = vec![49];
        let spans = spans(&torn, 0.02);
        assert_eq!(spans, [(0, 20), (20, 40), (80, 100)], "what was commanded in the gap acts for 30 ms");
        torn.gaps = vec![39, 49];
        assert_eq!(super::spans(&torn, 0.02), [(0, 20), (80, 100)], "nor one that ends right before it");
    }

    #[test]
    fn a_missing_torque_is_found_in_sign_and_size() {
        let model = Model::new(0.075);
        let t_s: Vec<f64> = (0..400).map(|row| f64::from(row) * 5e-4).collect();
        // 0.3 N m act that no command knows of.
        let position = t_s.iter().map(|t| 0.2 * t + 0.5 * 0.3 / 0.075 * t * t).collect();
        let residual = residual(&model, &recording(t_s, position), 0.05).unwrap();
        assert_eq!(residual.windows.len(), 3);
        assert!(residual.windows.iter().all(|window| (window.torque - 0.3).abs() < 1e-6), "{residual:?}");
        assert!(residual.rms() > 1e-5);
    }

    #[test]
    fn too_short_a_recording_says_so() {
        let error = residual(&Model::new(1.0), &regular(30), 0.05).unwrap_err();
        assert_eq!(
            error.to_string(),
            "hand.csv: 0.029 s long, and a window of 10 rows takes 0.050 s; record at least 2.0 s"
        );
    }

    #[test]
    fn windows_of_a_coarse_recording_are_as_long_as_ten_rows() {
        let t_s: Vec<f64> = (0..200).map(|row| f64::from(row) * 0.016).collect();
        let coarse = recording(t_s.clone(), t_s);
        let left = residual(&Model::new(1.0), &coarse, 0.05).unwrap();
        assert!((left.horizon_s - 0.16).abs() < 1e-12 && left.windows.len() == 19, "{left:?}");
    }

    #[test]
    fn a_few_windows_far_out_are_set_aside_and_many_are_not() {
        let recording = regular(1000);
        let with = |count: usize| {
            testing::residual(&recording, move |p, _| if p[0] < 0.01 * count as f64 - 1e-9 { 50.0 } else { 1.0 })
        };
        assert_eq!(with(3).usual().count(), 97);
        assert_eq!(with(20).usual().count(), 100);
        assert_eq!(with(0).usual().count(), 100);
        assert_eq!(Residual { horizon_s: 0.05, windows: Vec::new() }.rms(), 0.0);
    }
}
