//! An order over position, which no derivative tells: its neighbours are refitted while they are likelier.

use std::f64::consts::TAU;

use super::refit::{Refitted, SETTLED, refit};
use crate::problem::Problem;

/// Steps of a neighbour's refit: its amplitudes are linear, and the other values near.
const STEPS: usize = 3;
/// On a linear axis, which has no whole orders, steps from order to order halve this often: then a phase is off by a sixteenth of
/// a turn at the ends of the travel.
const HALVINGS: i32 = 3;

/// With another order of its last entry, where the likelihood has its top; none where it is there, or the entry has no order. A travel
/// of less than a revolution tells an order from the next only by little, and friction shifts the peak of the missing torque's
/// spectrum, which it came from.
pub(crate) fn with_likelier_order(problem: &Problem, from: &Refitted) -> Option<Refitted> {
    from.hypothesis.entries.last().filter(|entry| entry.effect.ordered)?;
    let mut best = None;
    for step in steps(problem) {
        for step in [step, -step] {
            while let Some(found) = likelier(problem, best.as_ref().unwrap_or(from), step) {
                best = Some(found);
            }
        }
    }
    best
}

/// Steps of an order, coarse ones first: to the next whole one of a revolution, or by parts of what the travel tells apart.
fn steps(problem: &Problem) -> Vec<f64> {
    let travel = problem.excitation.travel;
    match problem.excitation.linear {
        false => vec![1.0],
        true if travel > 0.0 => (1..=HALVINGS).map(|halvings| TAU / travel * f64::exp2(f64::from(-halvings))).collect(),
        true => Vec::new(),
    }
}

/// Refitted at another order of the last entry; none where that is not likelier, would be no order, or where no work is left.
fn likelier(problem: &Problem, from: &Refitted, step: f64) -> Option<Refitted> {
    let mut tried = from.hypothesis.clone();
    let order = &mut tried.entries.last_mut()?.values[0];
    *order += step;
    if *order <= 0.0 || problem.is_spent() {
        return None;
    }
    let found = refit(problem, &tried, &from.noise, STEPS)?;
    (found.log_likelihood - from.log_likelihood >= SETTLED).then_some(found)
}
