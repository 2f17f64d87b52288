//! Whether the residual repeats with the position.

use std::f64::consts::TAU;

use crate::screen::{Fit, Problem};

/// Highest order per revolution.
const HIGHEST: usize = 160;
/// Share of the squares that an order must hold to stand out.
const SHARE: f64 = 0.15;
/// and how many times the median of all orders.
const TIMES: f64 = 8.0;

/// The order per revolution that stands out of a fit's residual; none where none does, or less than two of its periods
/// were travelled.
pub(super) fn standing_order(problem: &Problem, fit: &Fit) -> Option<usize> {
    // The narrowest bumps let the highest orders pass.
    let narrow = problem.equations.iter().zip(fit.residual.iter()).filter(|(equation, _)| equation.width == 0);
    let points: Vec<(f64, f64)> = narrow
        .map(|(equation, residual)| (equation.row.mean(&problem.motions[equation.recording].cell_position), *residual))
        .collect();
    let (low, high) = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.0), h.max(p.0)));
    let total: f64 = points.iter().map(|(_, residual)| residual * residual).sum();
    let orders: Vec<usize> = (1..=HIGHEST).filter(|&order| order as f64 * (high - low) > 2.0 * TAU).collect();
    if orders.is_empty() || points.len() < 100 || total <= 0.0 {
        return None;
    }
    let power: Vec<f64> = orders.iter().map(|&order| share(&points, order as f64) / total).collect();
    let best = (0..power.len()).max_by(|&a, &b| power[a].total_cmp(&power[b]))?;
    let mut sorted = power.clone();
    sorted.sort_by(f64::total_cmp);
    (power[best] > SHARE && power[best] > TIMES * sorted[sorted.len() / 2]).then(|| orders[best])
}

/// Squares that a sine of an order explains: nearly twice the power of the sums, where many periods are travelled.
fn share(points: &[(f64, f64)], order: f64) -> f64 {
    let sum = points.iter().fold((0.0, 0.0), |(s, c), (position, residual)| {
        let (sine, cosine) = (order * position).sin_cos();
        (s + residual * sine, c + residual * cosine)
    });
    2.0 * (sum.0 * sum.0 + sum.1 * sum.1) / points.len() as f64
}
