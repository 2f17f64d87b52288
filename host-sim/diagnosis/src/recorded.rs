//! What the diagnosis takes of a recording.

use std::ops::Range;

use plant::Command;
use recording::{Mode, Recording};

/// One recording as the likelihood reads it: columns of equal length, time strictly rising.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// As answers name it.
    pub name: String,
    /// s.
    pub t_s: Vec<f64>,
    /// rad (m).
    pub position: Vec<f64>,
    /// Held from each row's time to the next.
    pub commands: Vec<Command>,
    /// Rows at which no residual is taken: behind gaps and at the beginning, where commands that are not known still act.
    pub skipped: Vec<bool>,
    /// Rows before which samples are missing.
    pub after_gap: Vec<bool>,
}

/// What was commanded in a gap acts this long after it, s: delays and lags of drive and fluid.
pub const ACTS_S: f64 = 0.03;
/// What was commanded before the first row acts this long after it, s: the longest dead time of the vocabulary, and that after which
/// a coefficient of viscosity that lags by the paper's 5 ms has fallen from that at rest, 55 N m s/rad, to that of motion.
const SETTLES_S: f64 = 0.05;
/// Of a short recording at most one row in this many is given up for what was commanded before it.
const GIVEN_UP: usize = 10;
/// Time constant of the speed estimate where a recording has none, s: the drive's default (control.md section 3).
const SPEED_FILTER_S: f64 = 0.001;

impl Recorded {
    /// The columns of a recording that the likelihood reads.
    pub fn new(recording: &Recording) -> Self {
        let rows = recording.t_s.len();
        let mut after_gap = vec![false; rows];
        let mut skipped = vec![false; rows];
        for &gap in &recording.gaps {
            after_gap[gap + 1] = true;
            let until = recording.t_s.partition_point(|t_s| *t_s < recording.t_s[gap + 1] + ACTS_S);
            skipped[gap + 1..until].fill(true);
        }
        Self {
            name: recording.name.clone(),
            t_s: recording.t_s.clone(),
            position: recording.position.clone(),
            commands: commands(recording),
            skipped,
            after_gap,
        }
    }

    /// Rows from a time up to another one, s.
    pub(crate) fn rows_between(&self, from_s: f64, to_s: f64) -> Range<usize> {
        self.t_s.partition_point(|t| *t < from_s)..self.t_s.partition_point(|t| *t < to_s)
    }

    /// The same without residuals where commands of before the first row may still act: that the first one was held before, as it is
    /// replayed, holds for no recording that begins with a step.
    pub(crate) fn settled(mut self) -> Self {
        let first_s = self.t_s.first().copied().unwrap_or_default();
        let rows = self.t_s.partition_point(|t_s| *t_s < first_s + SETTLES_S).min(self.rows() / GIVEN_UP);
        self.skipped[..rows].fill(true);
        self
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.t_s.len()
    }

    /// Median sample period, s; 0 with fewer than two rows.
    pub fn period_s(&self) -> f64 {
        let mut steps: Vec<f64> = self.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if steps.is_empty() {
            return 0.0;
        }
        let middle = steps.len() / 2;
        *steps.select_nth_unstable_by(middle, f64::total_cmp).1
    }

    /// From first to last row, s.
    pub fn duration_s(&self) -> f64 {
        self.t_s.last().zip(self.t_s.first()).map_or(0.0, |(last, first)| last - first)
    }
}

/// One command a row, each held to the next row; without a column of speed the drive's estimate is rebuilt from the position.
pub fn commands(recording: &Recording) -> Vec<Command> {
    let speed = recording.velocity.clone().unwrap_or_else(|| rebuilt_speed(recording));
    (0..recording.t_s.len())
        .map(|row| Command {
            torque: recording.effort_cmd[row],
            field_kv_mm: recording.field_cmd_kv_mm.as_ref().map_or(0.0, |field| field[row]),
            braking: recording.mode.as_ref().is_some_and(|mode| mode[row] == Mode::Brake),
            speed_estimate: speed[row],
            ..Command::default()
        })
        .collect()
}

/// The estimate of the drive from the recorded position: backward difference and first-order low-pass, begun anew after
/// each gap.
fn rebuilt_speed(recording: &Recording) -> Vec<f64> {
    let (t_s, position) = (&recording.t_s, &recording.position);
    let mut estimate = 0.0;
    let mut speed = Vec::with_capacity(t_s.len());
    for row in 0..t_s.len() {
        if row > 0 {
            let dt_s = t_s[row] - t_s[row - 1];
            let raw = (position[row] - position[row - 1]) / dt_s;
            let after_gap = recording.gaps.binary_search(&(row - 1)).is_ok();
            let gain = if after_gap { 1.0 } else { 1.0 - (-dt_s / SPEED_FILTER_S).exp() };
            estimate += gain * (raw - estimate);
        }
        speed.push(estimate);
    }
    speed
}
