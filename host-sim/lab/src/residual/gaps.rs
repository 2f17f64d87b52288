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
    // Once for all gaps: a log of an hour may have lost a row in ten thousand places.
    let columns: Vec<(&[f64], f64)> = std::iter::once(&recording.effort_cmd)
        .chain(&recording.field_cmd_kv_mm)
        .map(|column| (column.as_slice(), column.iter().fold(0.0, |peak: f64, value| peak.max(value.abs()))))
        .collect();
    for &gap in &recording.gaps {
        let changed = columns.iter().any(|(column, peak)| (column[gap + 1] - column[gap]).abs() > SAME * peak);
        if changed || t_s[gap + 1] - t_s[gap] > BRIDGED_S {
            let until = t_s.partition_point(|t| *t < t_s[gap + 1] + ACTS_S);
            all[gap + 1..until].fill(true);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual::testing::recording;

    /// Every tenth row lost of a log of an hour: what is looked at for each gap may not be the whole log.
    #[test]
    fn many_gaps_of_a_long_log_cost_no_more_than_its_rows() {
        let t_s: Vec<f64> = (0..2_000_000_u32).map(|row| f64::from(row + row / 10) * 5e-4).collect();
        let mut torn = recording(t_s.clone(), t_s);
        torn.gaps = (9..torn.rows() - 1).step_by(10).collect();
        torn.effort_cmd
            .iter_mut()
            .enumerate()
            .for_each(|(row, effort)| *effort = if row < 1_000_000 { 1.0 } else { 1.01 });
        // Short gaps over which the command was held: none of them matters.
        assert!(!unsettled(&torn).contains(&true));
        torn.effort_cmd[10] = 3.0;
        let lost = unsettled(&torn).iter().filter(|lost| **lost).count();
        assert!((54..=56).contains(&lost), "30 ms behind one gap, five of sixty rows lost: {lost}");
    }
}
