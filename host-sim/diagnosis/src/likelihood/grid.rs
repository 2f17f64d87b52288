//! Where the substeps of a recording lie, and what else every pass needs of it.

use crate::recorded::Recorded;

/// Longest substep of a search, s: with it the values of eight tuning cases of the 2 kHz servo were within a tenth of a standard deviation of
/// those with a quarter, a shaft's inertia ratio but one (0.2 %). Twice as long, in a log of 1.3 ms, left 837 units of likelihood of dry
/// friction to wrong samples ...
const LONGEST_S: f64 = 5e-4;
/// ... but a row of slower logs has no more than this many, which are enough (judge.md): where all were 0.5 ms long 19 of 29 tuning cases of
/// 2.5 to 5 ms ended at their budget of work, some at a wrong name before its rivals were compared; with these 6 do ...
const ENOUGH: f64 = 4.0;
/// ... and no row, such as one behind a gap, has more than this many.
const MOST: usize = 64;
/// Where values are estimated substeps are a part of those of a search, but none is shorter than this, s: that of the logs of 2 kHz
/// above.
const FINEST_S: f64 = LONGEST_S / 4.0;

/// Where the substeps of a recording lie; the same for every hypothesis.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// First substep of each row's interval to the next row, and one past the last.
    pub(crate) first: Vec<u32>,
    /// Length of the substeps of each row's interval, s.
    pub(crate) dt_s: Vec<f64>,
    /// Median sample period, s.
    pub(crate) period_s: f64,
    /// Root mean square of the commanded torque, N m (N).
    pub(crate) torque_rms: f64,
}

impl Grid {
    /// For the search in a recording.
    pub fn new(recorded: &Recorded) -> Self {
        Self::of(recorded, 1)
    }

    /// For the values of what was found: each substep in at most so many.
    pub(crate) fn finer(recorded: &Recorded, finer: usize) -> Self {
        Self::of(recorded, finer)
    }

    fn of(recorded: &Recorded, finer: usize) -> Self {
        let (mut first, mut dt_s, mut at) = (Vec::new(), Vec::new(), 0_u32);
        let period_s = recorded.period_s();
        for pair in recorded.t_s.windows(2) {
            let interval_s = pair[1] - pair[0];
            let coarse = substeps_in(interval_s, period_s);
            let enough = (0.999 * interval_s / (coarse as f64 * FINEST_S)).ceil().max(1.0) as usize;
            let count = coarse * finer.min(enough);
            first.push(at);
            dt_s.push(interval_s / count as f64);
            at += count as u32;
        }
        first.push(at);
        let squares: f64 = recorded.commands.iter().map(|command| command.torque * command.torque).sum();
        let torque_rms = (squares / recorded.rows().max(1) as f64).sqrt();
        Self { first, dt_s, period_s, torque_rms }
    }

    /// Substeps of a search over rows at these times, s, of that median distance, s.
    pub fn substeps_over(t_s: &[f64], period_s: f64) -> usize {
        t_s.windows(2).map(|pair| substeps_in(pair[1] - pair[0], period_s)).sum()
    }

    /// Number of substeps.
    pub fn substeps(&self) -> usize {
        self.first.last().map_or(0, |last| *last as usize)
    }
}

/// Longest substep of a search in a log of that median distance of its rows, s.
fn longest_s(period_s: f64) -> f64 {
    LONGEST_S.max(period_s / ENOUGH)
}

/// Substeps of a search from one row to the next, in a log of that median distance of its rows, s.
fn substeps_in(interval_s: f64, period_s: f64) -> usize {
    // A thousandth less, so that rounding of times makes no substep more.
    ((0.999 * interval_s / longest_s(period_s)).ceil() as usize).clamp(1, MOST)
}

#[cfg(test)]
mod tests {
    use super::{Grid, MOST};

    /// Ten rows that far apart, s.
    fn rows(period_s: f64) -> Vec<f64> {
        (0..10).map(|row| f64::from(row) * period_s).collect()
    }

    #[test]
    fn substeps_are_short_or_four_a_row() {
        for (period_s, each) in [(1e-4, 1), (5e-4, 1), (1.3e-3, 3), (2e-3, 4), (5e-3, 4), (0.031, 4)] {
            assert_eq!(Grid::substeps_over(&rows(period_s), period_s), 9 * each, "{period_s} s");
        }
    }

    #[test]
    fn a_row_behind_a_gap_has_substeps_of_the_same_length() {
        let mut t_s = rows(0.02);
        t_s.push(t_s[9] + 0.1);
        assert_eq!(Grid::substeps_over(&t_s, 0.02), 9 * 4 + 5 * 4);
        t_s.push(t_s[10] + 1e3);
        assert_eq!(Grid::substeps_over(&t_s, 0.02), 9 * 4 + 5 * 4 + MOST);
    }
}
