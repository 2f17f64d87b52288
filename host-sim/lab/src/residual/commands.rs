//! What drove the machine, as recorded.

use plant::Command;

use crate::read::{Mode, Recording};

/// What was commanded in a gap acts this long after it, s: delays and lags of drive and fluid.
const ACTS_S: f64 = 0.03;
/// A gap of at most this length is bridged by the held command, s,
const BRIDGED_S: f64 = 3e-3;
/// if the command is the same on both sides, up to this share of its largest.
const SAME: f64 = 0.02;

/// Rows at which commands that were lost in a gap may still act.
pub(crate) fn unsettled(recording: &Recording) -> Vec<bool> {
    let t_s = &recording.t_s;
    let mut all = vec![false; t_s.len()];
    let jumps = |column: &[f64], row: usize| {
        let peak = column.iter().fold(0.0_f64, |peak, value| peak.max(value.abs()));
        (column[row + 1] - column[row]).abs() > SAME * peak
    };
    for &gap in &recording.gaps {
        let field = recording.field_cmd_kv_mm.as_ref();
        let changed = jumps(&recording.effort_cmd, gap) || field.is_some_and(|field| jumps(field, gap));
        if changed || t_s[gap + 1] - t_s[gap] > BRIDGED_S {
            let until = t_s.partition_point(|t| *t < t_s[gap + 1] + ACTS_S);
            all[gap + 1..until].fill(true);
        }
    }
    all
}

/// Time constant of the speed estimate where a recording has none, s: the drive's default (control.md section 3).
const SPEED_FILTER_S: f64 = 0.001;

/// One command a row, each held to the next row.
pub fn recorded_commands(recording: &Recording) -> Vec<Command> {
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
