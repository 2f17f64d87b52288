//! An order over position, which no derivative tells: its neighbours are refitted while they are likelier.

use super::Entry;
use super::refit::{Refitted, SETTLED, refit};
use crate::problem::Problem;

/// Steps of a neighbour's refit: its amplitudes are linear, and the other values near.
const STEPS: usize = 3;
/// On a linear axis, which has no whole orders, steps from order to order halve this often, until the likelihood over them is a parabola:
/// then a phase is off by a sixteenth of a turn at the ends of the travel.
const HALVINGS: i32 = 3;
/// Parabolas that are laid over the likelihood, each over this share of the one before: Huber's loss flattens its sides, and a torque of eighty
/// times the noise takes three of them.
const PARABOLAS: i32 = 3;
const NEARER: f64 = 0.25;

/// With another order of one of its entries, where the likelihood has its top; none where it is there, or the entry has no order. A travel
/// of less than a revolution tells an order from the next only by little, and friction shifts the peak of the missing torque's
/// spectrum, which it came from.
pub(super) fn with_likelier_order(problem: &Problem, from: &Refitted, entry: usize) -> Option<Refitted> {
    from.hypothesis.entries.get(entry).filter(|entry| entry.effect.lowest_order.is_some())?;
    let steps = steps(problem);
    let mut best: Option<Refitted> = None;
    for &step in &steps {
        for step in [step, -step] {
            while let Some(found) = likelier(problem, best.as_ref().unwrap_or(from), entry, step) {
                best = Some(found);
            }
        }
    }
    if let Some(finest) = steps.last().filter(|_| problem.excitation.linear) {
        for step in (0..PARABOLAS).map(|before| NEARER.powi(before) * finest) {
            best = between(problem, best.as_ref().unwrap_or(from), entry, step).or(best);
        }
    }
    best
}

/// Steps of an order, coarse ones first: to the next whole one of a revolution, or by parts of what the travel tells apart.
fn steps(problem: &Problem) -> Vec<f64> {
    let apart = problem.excitation.orders_apart();
    match problem.excitation.linear {
        false => vec![apart],
        true if apart.is_finite() => (1..=HALVINGS).map(|halvings| apart * f64::exp2(f64::from(-halvings))).collect(),
        true => Vec::new(),
    }
}

/// Whether an entry, if it has an order, has one that comes back as often as its effect asks for.
pub(super) fn comes_back(problem: &Problem, entry: &Entry) -> bool {
    problem.excitation.lowest_order(entry.effect).is_none_or(|lowest| entry.values[0] >= lowest)
}

/// At the top of the parabola through an order and its neighbours on either side, which are less likely; none where that is not likelier.
fn between(problem: &Problem, from: &Refitted, entry: usize, step: f64) -> Option<Refitted> {
    let side = |step: f64| Some(from.log_likelihood - at_order(problem, from, entry, step)?.log_likelihood);
    let (below, above) = (side(-step)?, side(step)?);
    let top = 0.5 * step * (below - above) / (below + above);
    if top.is_finite() { likelier(problem, from, entry, top) } else { None }
}

/// How far an order of a linear axis is off, and what else moves with it.
pub(crate) struct OrderSpread {
    /// Variance of the order, were all rows independent, 1/m^2.
    pub(crate) variance: f64,
    /// Distance of the order on either side, 1/m.
    pub(crate) step: f64,
    /// Fitted values of the entry at the order that far below and above.
    pub(crate) sides: [Vec<f64>; 2],
}

/// Goes at a step over which the likelihood falls by half a unit, a standard deviation.
const SPREAD_GOES: usize = 3;

/// The curvature of the likelihood over the order of an entry, all else refitted; none where the entry has no order, or one of a revolution,
/// which is whole.
pub(crate) fn order_spread(problem: &Problem, from: &Refitted, entry: usize) -> Option<OrderSpread> {
    from.hypothesis.entries.get(entry).filter(|entry| entry.effect.lowest_order.is_some())?;
    let mut step = steps(problem).last().filter(|_| problem.excitation.linear)? * NEARER.powi(PARABOLAS);
    let mut found = None;
    for _ in 0..SPREAD_GOES {
        let [below, above] = [at_order(problem, from, entry, -step)?, at_order(problem, from, entry, step)?];
        let fall = from.log_likelihood - 0.5 * (below.log_likelihood + above.log_likelihood);
        let sides = [below, above].map(|side| side.hypothesis.entries[entry].values.clone());
        let variance = 0.5 * step * step / fall;
        if !(variance.is_finite() && variance > 0.0) {
            break;
        }
        found = Some(OrderSpread { variance, step, sides });
        step = variance.sqrt();
    }
    found
}

/// Refitted at another order of an entry; none where that is not likelier, would be no order, or where no work is left.
fn likelier(problem: &Problem, from: &Refitted, entry: usize, step: f64) -> Option<Refitted> {
    at_order(problem, from, entry, step).filter(|found| found.log_likelihood - from.log_likelihood >= SETTLED)
}

fn at_order(problem: &Problem, from: &Refitted, entry: usize, step: f64) -> Option<Refitted> {
    let mut tried = from.hypothesis.clone();
    let order = &mut tried.entries[entry].values[0];
    *order += step;
    if *order <= 0.0 || problem.is_spent() {
        return None;
    }
    refit(problem, &tried, &from.noise, STEPS)
}
