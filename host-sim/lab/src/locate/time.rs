//! Spans of time that hold most of the excess over the noise, and the first sample that noise does not explain.

use super::bootstrap::share;
use super::spans::loud;
use super::words::{EVENT_S, what_happens};
use crate::read::AxisKind;
use crate::report::{FirstUnexplained, Location, Region};
use crate::screen::{Fit, Problem};

/// Spans named at most.
const NAMED: usize = 5;
/// Rows further apart than this are not of one span, s.
const APART_S: f64 = 0.25;
/// Residuals beyond this many deviations are no noise, not even the worst of some thousand.
const BEYOND: f64 = 6.0;

/// Rows of the two narrow widths of one recording, in order of time: the widest blur what is short, the narrowest alone are
/// noisy.
struct Series {
    recording: usize,
    rows: Vec<usize>,
}

fn series(problem: &Problem) -> Vec<Series> {
    let of = |recording: usize| {
        let rows = (0..problem.equations.len()).filter(|&index| {
            let equation = &problem.equations[index];
            equation.recording == recording && equation.width < 2
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
            let what = what_happens(motion, start_s, end_s, axis, regions);
            Location {
                recording: motion.name.clone(),
                start_s,
                end_s,
                share: share.share,
                share_low: share.low,
                share_high: share.high,
                text: if spans.len() == 1 && end_s - start_s < EVENT_S { format!("once, {what}") } else { what },
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
    let widths = problem.equations.iter().map(|equation| equation.width + 1).max().unwrap_or(0);
    let of = |recording: usize| {
        // A wide bump sees what a narrow one does not, but blurs its time by its width.
        let each = (0..widths).filter_map(|width| onset_s(problem, fit, recording, width));
        let (at_s, _) = each.reduce(|fine, wide| if wide.0 + wide.1 < fine.0 { wide } else { fine })?;
        let motion = &problem.motions[recording];
        let row = motion.t_s.partition_point(|t| *t < at_s).min(motion.t_s.len() - 1);
        Some(FirstUnexplained { recording: motion.name.clone(), row: row + 1, t_s: motion.t_s[row] })
    };
    (0..problem.motions.len()).filter_map(of).collect()
}

/// When the residual of one width first rises beyond noise, s: where it passes half of what it rises to within the width
/// of a bump, which is where the middle of the bump meets a step of torque; and the width of the bump, s.
fn onset_s(problem: &Problem, fit: &Fit, recording: usize, width: usize) -> Option<(f64, f64)> {
    let own = problem.equations.iter().zip(fit.residual.iter());
    let own = own.filter(|(equation, _)| equation.recording == recording && equation.width == width);
    let rows: Vec<(f64, f64)> = own.map(|(equation, residual)| (equation.row.centre_s, residual.abs())).collect();
    let first = rows.iter().position(|(_, size)| *size >= BEYOND)?;
    let equation = problem.equations.iter().find(|equation| equation.width == width)?;
    let t_s = &problem.motions[equation.recording].t_s;
    let bump_s = t_s[equation.row.first_cell + equation.row.cell.len()] - t_s[equation.row.first_cell];
    let risen = rows[first..].iter().take_while(|(at_s, _)| *at_s <= rows[first].0 + bump_s);
    let peak = risen.clone().fold(0.0_f64, |peak, (_, size)| peak.max(*size));
    risen.into_iter().find(|(_, size)| *size >= 0.5 * peak).map(|(at_s, _)| (*at_s, bump_s))
}
