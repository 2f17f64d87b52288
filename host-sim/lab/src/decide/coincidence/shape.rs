//! Torques over position that together stand for a shape which none of them has.

use std::f64::consts::{PI, TAU};

use crate::effects::{Harmonic, Physics};
use crate::report::EffectAnswer;
use crate::screen::Problem;

/// Torques over position cancel where this share of the largest is left of their sum.
const CANCELS: f64 = 0.2;
/// A weight hangs at zero within this, rad.
const HANGS: f64 = 0.01;

/// In words, what torques over position are no effects of their own.
pub(super) fn coincidences(
    problem: &Problem,
    effects: &[EffectAnswer],
    improved: &Physics,
    barred: &dyn Fn(&str) -> bool,
) -> Vec<String> {
    let nominal = &problem.nominal;
    let found = [
        cancelling(problem, nominal, improved),
        closer_than_resolved(problem, nominal, improved),
        spring_like(problem, effects, barred),
    ];
    found.into_iter().flatten().collect()
}

fn added_cogging(nominal: &Physics, improved: &Physics) -> impl Iterator<Item = Harmonic> {
    improved.cogging.iter().filter(|wave| !nominal.cogging.contains(wave)).copied()
}

/// Added torques over position of which little is left in the sum: a shape that none of them has.
fn cancelling(problem: &Problem, nominal: &Physics, improved: &Physics) -> Option<String> {
    let changed = improved.gravity != nominal.gravity;
    let signed = [(1.0, improved.gravity), (-1.0, nominal.gravity)].into_iter().filter(|_| changed);
    let gravity: Vec<(f64, Harmonic)> = signed.filter_map(|(sign, wave)| Some((sign, wave?))).collect();
    let waves: Vec<Harmonic> = added_cogging(nominal, improved).collect();
    let spring = improved.spring - nominal.spring;
    let offset = improved.torque_offset - nominal.torque_offset;
    let (mut sizes, mut sum, mut rows) = (vec![0.0; 3 + waves.len()], 0.0, 0.0_f64);
    for position in problem.motions[..problem.fitted].iter().flat_map(|motion| &motion.smooth) {
        let weight: f64 = gravity.iter().map(|(sign, wave)| sign * wave.at(*position)).sum();
        let alone = [offset, weight, -spring * position];
        let torques: Vec<f64> = alone.into_iter().chain(waves.iter().map(|wave| wave.at(*position))).collect();
        sizes.iter_mut().zip(&torques).for_each(|(size, torque)| *size += torque * torque);
        sum += torques.iter().sum::<f64>().powi(2);
        rows += 1.0;
    }
    let largest = sizes.into_iter().fold(0.0, f64::max);
    (largest > 0.0 && sum < CANCELS * CANCELS * largest).then(|| {
        format!(
            "torques over position of up to {:.3} cancel to {:.3} in the mean: together they stand for a shape that none of \
             them has",
            (largest / rows).sqrt(),
            (sum / rows).sqrt()
        )
    })
}

/// Waves over position that differ by less than a period in the whole travel are a series for whatever shape it shows, and
/// so are a constant or a spring and a wave that is not passed once. A spring and a weight are the common exception.
fn closer_than_resolved(problem: &Problem, nominal: &Physics, improved: &Physics) -> Option<String> {
    let travel = problem.travel();
    let mut cogging: Vec<f64> = added_cogging(nominal, improved).map(|wave| wave.order).collect();
    cogging.sort_by(f64::total_cmp);
    let constant = improved.torque_offset != nominal.torque_offset || improved.asymmetry != nominal.asymmetry;
    let constant = constant.then(|| (0.0, "a constant torque".to_owned()));
    let spring = (improved.spring != nominal.spring).then(|| (0.0, "a spring".to_owned()));
    let named = |order: f64| (order, format!("order {order}"));
    let gravity = improved.gravity.filter(|_| improved.gravity != nominal.gravity).map(|wave| named(wave.order));
    let first = cogging.first().copied();
    let beside = [constant, spring, gravity].into_iter().flatten().filter_map(|low| Some((low, first?)));
    let waves = cogging.windows(2).map(|pair| (named(pair[0]), pair[1]));
    let ((_, low), high) = beside.chain(waves).find(|((low, _), high)| (high - low) * travel < TAU)?;
    Some(format!(
        "{low} and order {high} over position differ by less than a period in a travel of {travel:.3}: a shape, not its cause"
    ))
}

/// A weight that hangs exactly where the position is zero, and is not seen to bend, pulls like a spring.
fn spring_like(problem: &Problem, effects: &[EffectAnswer], barred: &dyn Fn(&str) -> bool) -> Option<String> {
    let weight = effects.iter().find(|effect| effect.id == "gravity_load").filter(|_| barred("spring_load"))?;
    let phase = weight.parameters.iter().find(|parameter| parameter.id.starts_with("phase"))?;
    let from_zero = phase.value - PI * (phase.value / PI).round();
    let half = 0.5 * (phase.high - phase.low);
    (problem.travel() < PI && half < HANGS && from_zero.abs() < HANGS.max(half)).then(|| {
        format!(
            "gravity_load: the weight hangs within {:.4} rad of where the position is zero, as a spring does by itself",
            from_zero.abs().max(half)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{effect, nominal, problem};
    use super::*;

    fn found(improved: &Physics) -> Vec<String> {
        coincidences(&problem(), &[], improved, &|_| false)
    }

    #[test]
    fn a_spring_that_takes_back_a_weight_is_neither() {
        let with = |spring: f64| {
            let gravity = Some(Harmonic { order: 1.0, sine: 12.9, cosine: 0.0 });
            Physics { spring, gravity, ..nominal() }
        };
        assert_eq!(found(&with(12.9)).len(), 1);
        assert_eq!(found(&with(2.0)), Vec::<String>::new());
    }

    #[test]
    fn waves_that_the_travel_does_not_tell_apart_are_a_series() {
        let travel = problem().travel();
        let wave = |order: f64| Harmonic { order, sine: 0.3, cosine: 0.0 };
        let with = |orders: &[f64]| Physics { cogging: orders.iter().map(|&order| wave(order)).collect(), ..nominal() };
        let period = TAU / travel;
        assert_eq!(found(&with(&[14.0, 14.0 + 0.9 * period])).len(), 1);
        assert_eq!(found(&with(&[14.0, 14.0 + 1.1 * period])), Vec::<String>::new());
        let weight = |order: f64| Physics { gravity: Some(wave(1.0)), ..with(&[order]) };
        assert_eq!(found(&weight(2.0)).len(), 1);
        assert_eq!(found(&weight(14.0)), Vec::<String>::new());
        assert_eq!(found(&Physics { spring: 0.2, ..with(&[0.9 * period]) }).len(), 1);
        assert_eq!(found(&Physics { torque_offset: 0.2, ..with(&[0.9 * period]) }).len(), 1);
        assert_eq!(found(&Physics { torque_offset: 0.2, ..with(&[1.1 * period]) }), Vec::<String>::new());
    }

    #[test]
    fn a_weight_that_hangs_at_zero_is_a_spring_where_that_may_not_be_named() {
        let weight = |phase: f64| {
            let mut weight = effect("gravity_load", &[0.6, phase]);
            weight.parameters[1].id = "phase_rad".to_owned();
            weight
        };
        let found =
            |phase: f64, barred: bool| coincidences(&problem(), &[weight(phase)], &nominal(), &|_| barred).len();
        assert_eq!((found(0.002, true), found(0.002, false), found(0.3, true)), (1, 0, 0));
    }
}
