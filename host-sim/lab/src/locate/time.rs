//! Spans of time that hold most of the excess over the noise, and the first sample that noise does not explain.

use super::bootstrap::share;
use super::spans::loud;
use super::words::what_happens;
use crate::read::AxisKind;
use crate::report::{FirstUnexplained, Location, Region};
use crate::screen::{Fit, Problem};

/// Spans named at most.
const NAMED: usize = 5;
/// Rows further apart than this are not of one span, s.
const APART_S: f64 = 0.25;
/// Residuals beyond this many deviations are no noise, not even the worst of some thousand.
const BEYOND: f64 = 6.0;

/// Rows of the middle width of one recording, in order of time.
struct Series {
    recording: usize,
    rows: Vec<usize>,
}

fn series(problem: &Problem) -> Vec<Series> {
    let of = |recording: usize| {
        let rows = (0..problem.equations.len()).filter(|&index| {
            let equation = &problem.equations[index];
            equation.recording == recording && equation.width == 1
        });
        Series { recording, rows: rows.collect() }
    };
    (0..problem.motions.len()).map(of).collect()
}

/// A span of rows `rows[from..to]` of a recording.
struct Span<'a> {
    recording: usize,
    rows: &'a [usize],
    excess: f64,
}

/// The spans between change points with the largest excess of a fit, largest share first; `regions` are the fit's.
pub fn locations(problem: &Problem, fit: &Fit, axis: AxisKind, regions: &[Region]) -> Vec<Location> {
    let excess = |row: usize| fit.residual[row] * fit.residual[row] - 1.0;
    let all = series(problem);
    let mut total = vec![0.0; problem.blocks];
    all.iter().flat_map(|series| &series.rows).for_each(|&row| total[problem.equations[row].block] += excess(row));
    let mut spans: Vec<Span<'_>> = Vec::new();
    for series in &all {
        let residuals: Vec<f64> = series.rows.iter().map(|&row| fit.residual[row]).collect();
        for (from, to) in loud(&residuals) {
            let centre_s = |row: usize| problem.equations[row].row.centre_s;
            for rows in series.rows[from..to].chunk_by(|&a, &b| centre_s(b) - centre_s(a) < APART_S) {
                let excess = rows.iter().map(|&row| excess(row)).sum();
                spans.push(Span { recording: series.recording, rows, excess });
            }
        }
    }
    spans.sort_by(|a, b| b.excess.total_cmp(&a.excess));
    let named = spans.iter().take(NAMED).filter(|span| span.excess > 0.0);
    named
        .map(|span| {
            let mut part = vec![0.0; problem.blocks];
            span.rows.iter().for_each(|&row| part[problem.equations[row].block] += excess(row));
            let share = share(&part, &total);
            let motion = &problem.motions[span.recording];
            let (start_s, end_s) = reach(problem, span.rows);
            Location {
                recording: motion.name.clone(),
                start_s,
                end_s,
                share: share.share,
                share_low: share.low,
                share_high: share.high,
                text: what_happens(motion, start_s, end_s, axis, regions),
            }
        })
        .collect()
}

/// From half a bump before the first centre to half a bump after the last, which is where most of their weight lies.
fn reach(problem: &Problem, rows: &[usize]) -> (f64, f64) {
    let ends = |row: usize| {
        let (row, t_s) = (&problem.equations[row].row, &problem.motions[problem.equations[row].recording].t_s);
        let half_s = 0.25 * (t_s[row.first_cell + row.cell.len()] - t_s[row.first_cell]);
        (row.centre_s - half_s, row.centre_s + half_s)
    };
    let (first, last) =
        (rows.first().map_or((0.0, 0.0), |&row| ends(row)), rows.last().map_or((0.0, 0.0), |&row| ends(row)));
    (first.0, last.1)
}

/// In each recording the first sample that the machine of a fit cannot explain with noise; none where noise explains all.
pub fn first_unexplained(problem: &Problem, fit: &Fit) -> Vec<FirstUnexplained> {
    let mut first: Vec<Option<f64>> = vec![None; problem.motions.len()];
    for (equation, residual) in problem.equations.iter().zip(fit.residual.iter()) {
        if residual.abs() < BEYOND {
            continue;
        }
        let t_s = &problem.motions[equation.recording].t_s;
        let row = &equation.row;
        // A strong torque shows when the tail of the bump meets it, a weak one in its middle.
        let within_s = 0.125 * (t_s[row.first_cell + row.cell.len()] - t_s[row.first_cell]);
        let at_s = row.centre_s + within_s;
        let earliest = &mut first[equation.recording];
        *earliest = Some(earliest.map_or(at_s, |before| before.min(at_s)));
    }
    let found = problem.motions.iter().zip(first).filter_map(|(motion, at_s)| Some((motion, at_s?)));
    found
        .map(|(motion, at_s)| {
            let row = motion.t_s.partition_point(|t| *t < at_s).min(motion.t_s.len() - 1);
            FirstUnexplained { recording: motion.name.clone(), row: row + 1, t_s: motion.t_s[row] }
        })
        .collect()
}
