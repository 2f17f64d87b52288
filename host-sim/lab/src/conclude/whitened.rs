//! What the likelihood leaves of each sample: white noise where the model is right.

use diagnosis::pipeline::Conclusion;
use diagnosis::problem::Problem;

/// Samples further apart than this many usual steps do not follow each other.
const APART: f64 = 1.5;

/// What one recording leaves of both machines, each over the standard deviation that its likelihood expects.
#[derive(Debug, Clone, PartialEq)]
pub struct Whitened {
    /// Name of the recording.
    pub recording: String,
    /// Usual time from one value to the next, s.
    pub period_s: f64,
    /// Under the nominal machine: stretches of values that follow each other.
    pub nominal: Vec<Vec<f64>>,
    /// Under the machine of the best hypothesis, likewise.
    pub improved: Vec<Vec<f64>>,
}

/// Of every recording, as far as it was looked at.
pub(super) fn all(problem: &Problem, conclusion: &Conclusion) -> Vec<Whitened> {
    let of = |step: &diagnosis::confidence_set::Step, index: usize| {
        let left = step.assessed.refitted.evaluation.innovations.get(index)?;
        Some(stretches(&problem.recordings[index].t_s, &left.whitened, &left.counted))
    };
    let each = problem.recordings.iter().enumerate().filter_map(|(index, recorded)| {
        let (_, nominal) = of(&conclusion.nominal, index)?;
        let (period_s, improved) = of(&conclusion.best, index)?;
        Some(Whitened { recording: recorded.name.clone(), period_s, nominal, improved })
    });
    each.collect()
}

/// The usual step of the rows that count, s, and their values, cut where rows are missing.
fn stretches(t_s: &[f64], values: &[f64], counted: &[bool]) -> (f64, Vec<Vec<f64>>) {
    let rows: Vec<usize> = (0..t_s.len().min(values.len())).filter(|&row| counted[row]).collect();
    let mut steps: Vec<f64> = rows.windows(2).map(|pair| t_s[pair[1]] - t_s[pair[0]]).collect();
    if steps.is_empty() {
        return (0.0, Vec::new());
    }
    let middle = steps.len() / 2;
    let period_s = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let follows = |one: &usize, next: &usize| t_s[*next] - t_s[*one] <= APART * period_s;
    let cut = rows.chunk_by(follows).map(|rows| rows.iter().map(|&row| values[row]).collect());
    (period_s, cut.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_do_not_count_and_gaps_cut() {
        let t_s = [0.0, 1.0, 2.0, 3.0, 7.0, 8.0, 9.0];
        let values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        let counted = [true, true, true, true, true, false, true];
        let (period_s, cut) = stretches(&t_s, &values, &counted);
        assert_eq!(period_s, 1.0);
        assert_eq!(cut, [vec![1.0, 2.0, 3.0, 4.0], vec![5.0], vec![7.0]]);
        assert_eq!(stretches(&[], &[], &[]), (0.0, Vec::new()));
    }
}
