//! Where commands that were lost may still act.

use diagnosis::recorded::ACTS_S;

use crate::read::Recording;

/// A gap of at most this length is bridged by the held command, s,
const BRIDGED_S: f64 = 3e-3;
/// if the command is the same on both sides, up to this share of its largest.
const SAME: f64 = 0.02;

/// Rows at which commands that were lost in a gap may still act.
pub(super) fn unsettled(recording: &Recording) -> Vec<bool> {
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
