//! What the diagnosis takes of a recording.

use plant::Command;

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
    /// Rows at which no residual is taken: behind gaps, where lost commands still act.
    pub skipped: Vec<bool>,
    /// Rows before which samples are missing.
    pub after_gap: Vec<bool>,
}

impl Recorded {
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
