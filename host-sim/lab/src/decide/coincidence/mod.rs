//! Several effects that are one cause in disguise.
//!
//! Some combinations do exactly what a single cause does: torque and field late by one time are a late position, inertia and
//! every drag off by one factor are the scale of the drive, a spring and a weight that cancel are the small difference of
//! their shapes. Where that single cause may be named, the search prefers it, for it changes fewer effects. Where it may not,
//! or is no effect of the vocabulary at all, values that agree by chance are no explanation.

mod curve;
mod flat;
mod held;
mod motion;
mod nothing;
mod shape;
mod spread;

pub(super) use curve::{bent, undecided};
pub(super) use flat::flat;
pub(super) use held::held;
pub(super) use spread::spread;

use super::checks::neutral;
use crate::effects::{Effect, Physics, find};
use crate::read::AxisKind;
use crate::report::{EffectAnswer, Interval};
use crate::screen::Problem;

/// Two values agree where they are no further apart than this many times their common interval.
const AGREES: f64 = 2.0;

/// A resolver errs by this much, 10 arcmin, rad: over less than half a turn an error of order one scales the speed by as much.
const SENSOR_ERROR_RAD: f64 = 0.003;

/// A value with the half-width of its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Estimate {
    value: f64,
    half: f64,
}

impl Estimate {
    fn of(interval: &Interval) -> Self {
        Self { value: interval.value, half: 0.5 * (interval.high - interval.low) }
    }

    /// With the nominal value taken off.
    fn beyond(self, nominal: f64) -> Self {
        Self { value: self.value - nominal, ..self }
    }

    fn over(self, nominal: f64) -> Self {
        Self { value: self.value / nominal, half: self.half / nominal.abs() }
    }

    fn negative(self) -> Self {
        Self { value: -self.value, ..self }
    }

    fn agrees(self, other: Self) -> bool {
        (self.value - other.value).abs() <= AGREES * self.half.hypot(other.half)
    }
}

/// In words, which effects of an answer are one cause that the `vocabulary` does not have. `improved` is the machine with
/// the effects.
pub(super) fn coincidences(
    problem: &Problem,
    effects: &[EffectAnswer],
    improved: &Physics,
    (vocabulary, axis): (&[&'static Effect], AxisKind),
) -> Vec<String> {
    let nominal = &problem.nominal;
    let barred = |id: &str| !vocabulary.iter().any(|effect| effect.id == id);
    let delays = [
        ("field_lag", lags_alike(effects)),
        ("sensor_latency", delayed_alike(nominal, effects)),
        ("torque_delay", late_and_early(effects, "field_dead_time", unchanged(nominal, "field_dead_time"))),
        ("field_dead_time", late_and_early(effects, "torque_delay", Some(nominal.torque_delay_s))),
    ];
    let mut found: Vec<String> =
        delays.into_iter().filter(|(one, _)| barred(one)).filter_map(|(_, words)| words).collect();
    found.extend(one_scale(nominal, effects, &barred));
    if barred("compliance") && may_be_no_gap(effects) {
        found.push("backlash: the gap may be none, and without one it is a shaft".to_owned());
    }
    found.extend(behind_the_limit(nominal, effects));
    found.extend(nothing::coincidences(nominal, effects));
    found.extend(motion::in_step(problem, effects));
    found.extend(scaled_by_the_sensor(problem, effects).filter(|_| axis == AxisKind::Rotary));
    found.extend(shape::coincidences(problem, effects, improved, &barred));
    found
}

/// Whether there is a backlash whose gap may be zero.
pub(super) fn may_be_no_gap(effects: &[EffectAnswer]) -> bool {
    let gap = effects.iter().find(|effect| effect.id == "backlash").and_then(|effect| effect.parameters.first());
    gap.is_some_and(|gap| gap.low <= 0.0)
}

/// A bias of the drive is within its limit; a limit higher by as much, or by so much that nothing reaches it (its interval has
/// no width), says that this one is not the drive's.
fn behind_the_limit(nominal: &Physics, effects: &[EffectAnswer]) -> Option<String> {
    let offset = first(effects, "torque_offset")?.beyond(nominal.torque_offset);
    let raised = first(effects, "torque_saturation")?.beyond(nominal.torque_limit);
    let size = if offset.value < 0.0 { offset.negative() } else { offset };
    let unreached = raised.half == 0.0 && raised.value > 0.0;
    (unreached || size.agrees(raised)).then(|| {
        format!(
            "torque_offset of {:.4} acts on top of the drive's limit too, which a bias of the drive cannot: something behind \
             the drive pushes one way",
            offset.value
        )
    })
}

/// An inertia as little off as a sensor scales the acceleration.
fn scaled_by_the_sensor(problem: &Problem, effects: &[EffectAnswer]) -> Option<String> {
    let inertia = first(effects, "inertia")?.over(problem.nominal.inertia);
    let little = (inertia.value - 1.0).abs() < SENSOR_ERROR_RAD && problem.travel() < std::f64::consts::PI;
    little.then(|| {
        format!(
            "inertia: {:+.2} % is what a position sensor that errs by {:.1} mrad over the turn shows on this travel",
            100.0 * (inertia.value - 1.0),
            1e3 * (inertia.value - 1.0).abs()
        )
    })
}

/// The first value of an effect of an answer.
fn first(effects: &[EffectAnswer], id: &str) -> Option<Estimate> {
    let effect = effects.iter().find(|effect| effect.id == id)?;
    effect.parameters.first().map(Estimate::of)
}

/// The first value of an effect on a machine that has none of it.
fn unchanged(nominal: &Physics, id: &str) -> Option<f64> {
    neutral(find(id)?, nominal, 1)?.first().copied()
}

fn lags_alike(effects: &[EffectAnswer]) -> Option<String> {
    let lags = effects.iter().find(|effect| effect.id == "field_lag_asymmetry")?;
    let [rise, fall] = lags.parameters.as_slice() else { return None };
    let alike = Estimate::of(rise).agrees(Estimate::of(fall));
    alike.then(|| "field_lag_asymmetry: rise and fall do not differ, so what is missing is no asymmetry".to_owned())
}

fn delayed_alike(nominal: &Physics, effects: &[EffectAnswer]) -> Option<String> {
    let torque = first(effects, "torque_delay")?.beyond(nominal.torque_delay_s);
    let field = first(effects, "field_dead_time")?.beyond(unchanged(nominal, "field_dead_time")?);
    torque.agrees(field).then(|| {
        format!(
            "torque_delay and field_dead_time are both {:.4} s more than the model has: one cause delays both, or the position \
             is late",
            torque.value
        )
    })
}

/// A position reported late and one command early by the same time is the other command late.
fn late_and_early(effects: &[EffectAnswer], command: &str, nominal_s: Option<f64>) -> Option<String> {
    let late = first(effects, "sensor_latency")?;
    let early = first(effects, command)?.beyond(nominal_s?);
    late.agrees(early.negative()).then(|| {
        format!(
            "sensor_latency of {:.4} s and a {command} that is less than the model's by the same time are one cause: \
             something else is late",
            late.value
        )
    })
}

/// The balance of torques is fixed up to one scale: all of its terms but one off by the same factor are that one off, and
/// where no term is left that is not, only the drive's limit is another.
fn one_scale(nominal: &Physics, effects: &[EffectAnswer], barred: &dyn Fn(&str) -> bool) -> Option<String> {
    let terms = ["torque_gain", "inertia", "coulomb_friction", "viscous_friction", "er_strength"];
    let terms = terms.into_iter().filter_map(|id| Some((id, unchanged(nominal, id).filter(|size| *size > 0.0)?)));
    let (changed, same): (Vec<_>, Vec<_>) = terms.partition(|(id, _)| first(effects, id).is_some());
    let single = match same.as_slice() {
        [] => "torque_saturation",
        [(single, _)] => *single,
        _ => return None,
    };
    let factors: Vec<Estimate> =
        changed.iter().filter_map(|(id, size)| Some(first(effects, id)?.over(*size))).collect();
    let (one, others) = factors.split_first()?;
    let agree = others.len() > 1 && others.iter().all(|other| other.agrees(*one));
    (agree && barred(single)).then(|| {
        let ids: Vec<&str> = changed.iter().map(|(id, _)| *id).collect();
        format!("{} are all {:.4} times the model's: one scale is off, not each of them", ids.join(", "), one.value)
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::decide::testing::machine;
    use crate::effects::VOCABULARY;
    use crate::report::Evidence;
    use crate::screen::Motion;

    pub(super) fn nominal() -> Physics {
        Physics::nominal(&machine())
    }

    pub(super) fn problem() -> Problem {
        let recorded = crate::decide::testing::recording(&nominal(), 0.05, 2.0, 1);
        Problem::new(vec![Motion::new(&recorded, &nominal(), 1.3e-5)], 1, nominal())
    }

    pub(super) fn effect(id: &str, values: &[f64]) -> EffectAnswer {
        let interval = |&value: &f64| Interval {
            id: String::new(),
            value,
            low: value - 1e-3 * value.abs(),
            high: value + 1e-3 * value.abs(),
            unit: String::new(),
        };
        EffectAnswer {
            id: id.to_owned(),
            text: String::new(),
            equivalent: Vec::new(),
            parameters: values.iter().map(interval).collect(),
            evidence: Evidence { heldout_gain: 0.5, p_value: 0.0, excess_explained: 1.0 },
            recording: None,
        }
    }

    fn without(barred: &str) -> Vec<&'static Effect> {
        VOCABULARY.iter().copied().filter(|effect| effect.id != barred).collect()
    }

    fn found(effects: &[EffectAnswer], vocabulary: &[&'static Effect]) -> Vec<String> {
        coincidences(&problem(), effects, &nominal(), (vocabulary, AxisKind::Rotary))
    }

    #[test]
    fn one_cause_in_two_effects_is_told_where_it_may_not_be_named() {
        // Of the nominal machine: torque delay 5 ms, dead time 2 ms.
        let cases = [
            ("sensor_latency", vec![effect("torque_delay", &[0.006]), effect("field_dead_time", &[0.003])]),
            ("torque_delay", vec![effect("sensor_latency", &[0.001]), effect("field_dead_time", &[0.001])]),
            ("field_dead_time", vec![effect("sensor_latency", &[0.001]), effect("torque_delay", &[0.004])]),
            ("field_lag", vec![effect("field_lag_asymmetry", &[0.005, 0.005])]),
        ];
        for (one, effects) in cases {
            assert_eq!(found(&effects, &without(one)).len(), 1, "{one}");
            assert_eq!(found(&effects, &VOCABULARY), Vec::<String>::new(), "{one}");
        }
        let two = [effect("torque_delay", &[0.006]), effect("field_dead_time", &[0.0035])];
        assert!(found(&two, &without("sensor_latency")).is_empty());
    }

    #[test]
    fn a_gap_that_may_be_none_is_a_shaft_where_that_may_not_be_named() {
        let mut gap = effect("backlash", &[0.001, 50.0, 0.1, 0.3]);
        assert!(found(&[gap.clone()], &without("compliance")).is_empty());
        gap.parameters[0].low = 0.0;
        assert_eq!(found(&[gap.clone()], &without("compliance")).len(), 1);
        assert!(found(&[gap], &VOCABULARY).is_empty());
    }

    #[test]
    fn an_offset_that_the_limit_does_not_clip_is_not_the_drives() {
        let machine = Physics { torque_limit: 30.0, ..nominal() };
        let offset = effect("torque_offset", &[-0.2]);
        let judged = |limit: EffectAnswer| behind_the_limit(&machine, &[offset.clone(), limit]);
        let limited = |limit: f64| effect("torque_saturation", &[limit]);
        assert!(judged(limited(30.2)).is_some());
        assert!(judged(limited(20.0)).is_none() && judged(limited(31.0)).is_none());
        let mut unreached = limited(31.0);
        unreached.parameters.iter_mut().for_each(|limit| (limit.low, limit.high) = (limit.value, limit.value));
        assert!(judged(unreached).is_some());
    }

    #[test]
    fn an_inertia_that_is_hardly_off_may_be_the_sensor() {
        let off = |share: f64| [effect("inertia", &[(1.0 + share) * nominal().inertia])];
        assert_eq!(found(&off(0.002), &VOCABULARY).len(), 1);
        assert!(found(&off(0.01), &VOCABULARY).is_empty());
    }

    #[test]
    fn all_terms_but_one_off_by_a_factor_are_one_scale() {
        let scaled = |factor: f64| {
            let machine = nominal();
            [
                effect("inertia", &[1.1 * machine.inertia]),
                effect("coulomb_friction", &[1.1 * machine.coulomb]),
                effect("er_strength", &[factor]),
            ]
        };
        let one = found(&scaled(1.1), &without("torque_gain"));
        assert!(one.len() == 1 && one[0].contains("1.1000 times"), "{one:?}");
        assert!(found(&scaled(1.2), &without("torque_gain")).is_empty());
        let all = |factor: f64| [scaled(1.1).as_slice(), &[effect("torque_gain", &[factor])]].concat();
        assert_eq!(found(&all(1.1), &without("torque_saturation")).len(), 1);
        assert!(found(&all(1.1), &VOCABULARY).is_empty());
        assert!(found(&all(1.2), &without("torque_saturation")).is_empty());
    }
}
