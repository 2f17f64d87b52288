//! The effects of the best model, and those that were not taken.

use super::fitted::explained;
use super::glitches::glitches;
use super::prepare::Searched;
use super::{Refined, Request, intervals, simulated};
use crate::effects::Effect;
use crate::read::{AxisKind, vocabulary};
use crate::report::{EffectAnswer, Evidence, Interval, Rejected};
use crate::screen::{Active, MAX_P, MIN_GAIN, Outcome, Refitter, Trial};

/// What is not known of a gap's contact moves its values by these shares: gap, resonance, damping ratio, inertia ratio. The
/// plant's contact may pull while it opens, that of a machine may not; recordings of `host-sim/conceal`, whose contact does
/// not, are refitted with up to 0.4, 0.02, 2.8 and 0.7 % too little, and a machine's contact may differ as much the other way.
const CONTACT: [f64; 4] = [0.005, 0.000_5, 0.03, 0.006];

/// Every effect of the best model with its evidence.
pub(super) fn effects(
    request: &Request<'_>,
    searched: &Searched,
    refined: &Refined,
    alike: &[Vec<&'static Effect>],
) -> Vec<EffectAnswer> {
    let refitter = Refitter::new(&searched.problem, &searched.outcome);
    let each = 0..searched.outcome.fit.active.len();
    let mut effects: Vec<EffectAnswer> =
        each.map(|index| effect_answer(request, searched, &refitter, (refined, alike), index)).collect();
    effects.extend(glitches(request, &searched.problem));
    effects
}

fn effect_answer(
    request: &Request<'_>,
    searched: &Searched,
    refitter: &Refitter<'_>,
    (refined, alike): (&Refined, &[Vec<&'static Effect>]),
    index: usize,
) -> EffectAnswer {
    let (problem, outcome) = (&searched.problem, &searched.outcome);
    let entry = &outcome.fit.active[index];
    let simulated = if entry.is_held() { simulated::evidence(searched, refined, index) } else { None };
    let evidence = simulated.unwrap_or_else(|| evidence(outcome, refitter, index));
    let recording = entry
        .effect
        .is_event()
        .then(|| problem.motions.get(entry.values[0] as usize).map(|motion| motion.name.clone()))
        .flatten();
    let others = alike.get(index).map_or(&[] as &[&Effect], Vec::as_slice);
    EffectAnswer {
        id: entry.effect.id.to_owned(),
        text: entry.effect.sentence.to_owned(),
        equivalent: others.iter().map(|effect| effect.id.to_owned()).collect(),
        parameters: values(searched, refined, index, request.machine.axis.kind),
        evidence,
        recording,
    }
}

/// Evidence of one effect in the torque balance.
fn evidence(outcome: &Outcome, refitter: &Refitter<'_>, index: usize) -> Evidence {
    let fit = &outcome.fit;
    let mut rest = fit.active.clone();
    rest.remove(index);
    let without = refitter.fit(&rest);
    Evidence {
        heldout_gain: 1.0 - (fit.heldout_sse() / without.heldout_sse().max(1e-300)).sqrt(),
        p_value: (refitter.p_value(&without, fit) * outcome.variants as f64).min(1.0),
        excess_explained: explained(without.sse, fit.sse, fit.residual_count()),
    }
}

/// Values of one effect with their intervals.
fn values(searched: &Searched, refined: &Refined, index: usize, axis: AxisKind) -> Vec<Interval> {
    let entry = &searched.outcome.fit.active[index];
    let names = vocabulary::effect(entry.effect.id).map_or(&[] as &[vocabulary::Parameter], |kind| kind.parameters);
    let mut values = intervals(&refined.active, &refined.covariance, index);
    if entry.effect.is_gap() && refined.time.is_some() {
        // The filter that carries a load through the torque balance takes in part of what wrong values do.
        values.iter_mut().zip(CONTACT).for_each(|((value, half), share)| *half = half.hypot(share * *value));
    } else if !entry.effect.is_event() {
        let weak = (entry.effect.report)(&entry.values);
        names.iter().zip(&mut values).zip(weak).for_each(|((name, value), weak)| *value = widened(name, *value, weak));
    }
    let mut parameters = parameters(names, &values, axis);
    if let Some((_, spans)) = refined.spans.as_ref().filter(|(at, _)| *at == index) {
        wider(&mut parameters, spans);
    }
    if let Some(reach) = simulated::reach(searched, refined, index) {
        wider(&mut parameters, &reach);
    }
    within_bounds(&refined.active[index], &mut parameters);
    parameters
}

/// Two estimates of the same data, in the time domain and in the weak form, that differ show what the form of the model
/// leaves open; an interval reaches from one to the other at least as its own error adds to that.
fn widened(name: &vocabulary::Parameter, (value, half): (f64, f64), weak: f64) -> (f64, f64) {
    let apart = value - weak;
    let turn = std::f64::consts::TAU;
    let apart = if name.id(AxisKind::Rotary) == "phase_rad" { apart - turn * (apart / turn).round() } else { apart };
    (value, half.hypot(apart))
}

/// Intervals that reach at least as far as other values were found to be as likely.
fn wider(parameters: &mut [Interval], spans: &[(f64, f64)]) {
    for (parameter, (low, high)) in parameters.iter_mut().zip(spans) {
        (parameter.low, parameter.high) = (parameter.low.min(*low), parameter.high.max(*high));
    }
}

/// No interval leaves what physics allows; only for values that are reported as they are fitted.
fn within_bounds(entry: &Active, parameters: &mut [Interval]) {
    let fitted = entry.values.iter().zip(&entry.ranges).skip(entry.values.len().saturating_sub(parameters.len()));
    for (parameter, (value, range)) in parameters.iter_mut().zip(fitted) {
        if parameter.value == *value {
            (parameter.low, parameter.high) = (parameter.low.max(range.low), parameter.high.min(range.high));
        }
    }
}

pub(super) fn parameters(names: &[vocabulary::Parameter], values: &[(f64, f64)], axis: AxisKind) -> Vec<Interval> {
    let pairs = names.iter().zip(values);
    pairs
        .map(|(name, &(value, half))| Interval {
            id: name.id(axis).to_owned(),
            value,
            low: value - half,
            high: value + half,
            unit: name.unit(axis).to_owned(),
        })
        .collect()
}

/// Effects that were tried and not taken, or taken back.
pub(super) fn rejected(
    request: &Request<'_>,
    outcome: &Outcome,
    effects: &[EffectAnswer],
    taken_back: &[&'static Effect],
) -> Vec<Rejected> {
    let axis = request.machine.axis.kind;
    let open = outcome.trials.iter().filter(|trial| !effects.iter().any(|effect| effect.id == trial.effect.id));
    let why = |trial: &Trial| {
        if taken_back.contains(&trial.effect) {
            return "simulated windows fit as well without it".to_owned();
        }
        why(trial, axis)
    };
    open.map(|trial| Rejected { id: trial.effect.id.to_owned(), heldout_gain: trial.gain, why: why(trial) }).collect()
}

fn why(trial: &Trial, axis: AxisKind) -> String {
    if trial.gain < MIN_GAIN {
        return format!("less than {:.0} % less held-out error", 100.0 * MIN_GAIN);
    }
    if trial.p_value >= MAX_P {
        return format!("not significant after correction, p = {:.1e}", trial.p_value);
    }
    if trial.at_bound() {
        return "its best value stands at the bound of what was searched".to_owned();
    }
    if !trial.accepted() {
        return format!("its gain is not in enough of the blocks, t = {:.1} over blocks", trial.t);
    }
    let names = vocabulary::effect(trial.effect.id).map_or(&[] as &[vocabulary::Parameter], |kind| kind.parameters);
    let values = trial.fit.active.last().map_or(Vec::new(), |entry| (entry.effect.report)(&entry.values));
    let found: Vec<String> =
        names.iter().zip(values).map(|(name, value)| format!("{} = {value:.5}", name.id(axis))).collect();
    format!("another effect predicts better, or as well with fewer parameters; alone it would be {}", found.join(", "))
}
