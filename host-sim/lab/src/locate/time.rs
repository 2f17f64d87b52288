//! Blocks of time that hold most of the excess over the noise.

use crate::report::Location;
use crate::screen::{Fit, Problem};

/// Spans named at most.
const NAMED: usize = 5;

/// The blocks with the largest excess of a fit, neighbours joined, largest share first.
pub fn locations(problem: &Problem, fit: &Fit) -> Vec<Location> {
    let mut excess = vec![0.0; problem.blocks];
    let mut spans: Vec<Option<(usize, f64, f64)>> = vec![None; problem.blocks];
    for (index, equation) in problem.equations.iter().enumerate() {
        let residual = fit.residual[index];
        excess[equation.block] += residual * residual - 1.0;
        let at_s = equation.row.centre_s;
        let span = spans[equation.block].get_or_insert((equation.recording, at_s, at_s));
        (span.1, span.2) = (span.1.min(at_s), span.2.max(at_s));
    }
    let total: f64 = excess.iter().map(|e| e.max(0.0)).sum();
    let mut order: Vec<usize> = (0..problem.blocks).filter(|&block| excess[block] > 0.0).collect();
    order.sort_by(|&a, &b| excess[b].total_cmp(&excess[a]));
    let top = order.into_iter().take(NAMED).filter_map(|block| spans[block].map(|span| (block, span)));
    top.map(|(block, (recording, start_s, end_s))| Location {
        recording: problem.motions[recording].name.clone(),
        start_s,
        end_s,
        share: excess[block] / total,
        text: text(problem, recording, start_s, end_s),
    })
    .collect()
}

/// What the machine does in a span.
fn text(problem: &Problem, recording: usize, start_s: f64, end_s: f64) -> String {
    let motion = &problem.motions[recording];
    let (from, to) = (
        motion.t_s.partition_point(|t| *t < start_s),
        motion.t_s.partition_point(|t| *t <= end_s).min(motion.speed.len()),
    );
    let part = &motion.speed[from.min(to)..to];
    let peak = part.iter().fold(0.0_f64, |peak, w| peak.max(w.abs()));
    let mean = part.iter().sum::<f64>() / part.len().max(1) as f64;
    let direction = if mean.abs() < 0.3 * peak {
        "to and fro"
    } else if mean > 0.0 {
        "forwards"
    } else {
        "backwards"
    };
    format!("moving {direction}, up to {peak:.2} per second")
}
