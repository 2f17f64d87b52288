//! A gap, settled by simulation where the refit in the time domain does not hold.
//!
//! Impacts make the torque balance of a load in its gap a poor witness: the filter that keeps the load on track takes in
//! part of what wrong values do. Beside something that is missing, slopes do not lead to the optimum of the windows either;
//! so the values are felt out, and every place that leaves hardly more belongs to their intervals.

use std::cell::RefCell;

use nalgebra::DVector;

use super::prepare::Searched;
use super::{Refined, Request};
use crate::refit::Probe;
use crate::screen::{Active, minimise};

/// Passes of the simplex, each from where the one before ended,
const PASSES: usize = 3;
/// with so many evaluations each.
const EVALUATIONS: usize = 110;
/// What leaves no more than this many times the least is as likely: 95 % of the F-distribution of four values over sixty
/// windows.
const AS_LIKELY: f64 = 1.18;

/// Steps away from the best of each value, as a share of it.
const STEPS: [f64; 9] = [0.001, 0.002, 0.004, 0.008, 0.016, 0.03, 0.06, 0.12, 0.25];

/// Places that were tried: what they leave of the windows, and the values.
type Trail = Vec<(f64, Vec<f64>)>;

/// Which of the effects is a gap.
pub(super) fn gap(active: &[Active]) -> Option<usize> {
    active.iter().position(|entry| entry.effect.is_gap())
}

/// The same with the values of a gap settled by simulation, where the refit in the time domain did not do that and where it is
/// better; anything else is left as it is.
pub(super) fn settled(request: &Request<'_>, searched: &Searched, refined: Refined) -> Refined {
    let Some(index) = gap(&refined.active).filter(|_| refined.time.is_none()) else { return refined };
    let trail = felt_out(searched, &refined.active, index);
    let Some((least, best)) = lowest(&trail) else { return refined };
    let mut active = refined.active.clone();
    active[index].values.clone_from(&best);
    let rms = |active: &[Active]| searched.windows_rms(request, active);
    let better = rms(&active).and_then(|after| Ok(after <= rms(&refined.active)?)).unwrap_or(false);
    if !better {
        return refined;
    }
    let likely = trail.iter().filter(|(loss, _)| *loss <= AS_LIKELY * least);
    let spans = likely.fold(best.iter().map(|&value| (value, value)).collect::<Vec<_>>(), |spans, (_, values)| {
        spans.iter().zip(values).map(|(&(low, high), &value)| (low.min(value), high.max(value))).collect()
    });
    Refined { active, spans: Some((index, spans)), ..refined }
}

/// Everything that was tried: passes of the simplex, and from the best place each value alone outwards until the windows
/// miss it.
fn felt_out(searched: &Searched, from: &[Active], index: usize) -> Trail {
    let (start, probe) = (&from[index], Probe::spread(&searched.problem, searched.fitted()));
    let trail = RefCell::new(Trail::new());
    let cost = |logs: &DVector<f64>| {
        let mut active = from.to_vec();
        let values = &mut active[index].values;
        for ((value, range), log) in values.iter_mut().zip(&start.ranges).zip(logs.iter()) {
            *value = (*value * log.exp()).clamp(range.low, range.high);
        }
        let over = searched.problem.budget.check();
        let loss = if over { None } else { probe.loss(&active) }.unwrap_or(f64::INFINITY);
        trail.borrow_mut().push((loss, active[index].values.clone()));
        loss
    };
    let (mut least, mut at) = (f64::INFINITY, DVector::zeros(start.values.len()));
    for _ in 0..PASSES {
        (least, at) = minimise(&at, EVALUATIONS, cost);
    }
    for (value, sign) in (0..at.len()).flat_map(|value| [(value, 1.0), (value, -1.0)]) {
        for step in STEPS {
            let mut logs = at.clone();
            logs[value] += sign * step;
            if cost(&logs) > AS_LIKELY * least {
                break;
            }
        }
    }
    trail.into_inner()
}

fn lowest(trail: &Trail) -> Option<(f64, Vec<f64>)> {
    trail.iter().min_by(|a, b| a.0.total_cmp(&b.0)).cloned()
}
