//! Several effects that are one cause in disguise.
//!
//! Some combinations do exactly what a single cause does: torque and field late by one time are a late position, inertia and
//! every drag off by one factor are the scale of the drive, a spring and a weight that cancel are the small difference of
//! their shapes. Where that single cause may be named, the search prefers it, for it changes fewer effects. Where it may not,
//! or is no effect of the vocabulary at all, values that agree by chance are no explanation.

mod shape;

use crate::effects::{Effect, Physics};
use crate::report::{EffectAnswer, Interval};
use crate::screen::Problem;

/// Two values agree where they are no further apart than this many times their common interval.
const AGREES: f64 = 2.0;

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
    vocabulary: &[&'static Effect],
) -> Vec<String> {
    let nominal = &problem.nominal;
    let barred = |id: &str| !vocabulary.iter().any(|effect| effect.id == id);
    let delays = [
        ("field_lag", lags_alike(effects)),
        ("sensor_latency", delayed_alike(nominal, effects)),
        ("torque_delay", late_and_early(effects, "field_dead_time", nominal_dead_time_s(nominal))),
        ("field_dead_time", late_and_early(effects, "torque_delay", Some(nominal.torque_delay_s))),
    ];
    let mut found: Vec<String> =
        delays.into_iter().filter(|(one, _)| barred(one)).filter_map(|(_, words)| words).collect();
    found.extend(one_scale(nominal, effects, &barred));
    found.extend(shape::coincidences(problem, effects, improved, &barred));
    found
}

/// The first value of an effect of an answer.
fn first(effects: &[EffectAnswer], id: &str) -> Option<Estimate> {
    let effect = effects.iter().find(|effect| effect.id == id)?;
    effect.parameters.first().map(Estimate::of)
}

fn nominal_dead_time_s(nominal: &Physics) -> Option<f64> {
    nominal.damper.as_ref().map(|damper| damper.dead_time_s)
}

fn lags_alike(effects: &[EffectAnswer]) -> Option<String> {
    let lags = effects.iter().find(|effect| effect.id == "field_lag_asymmetry")?;
    let [rise, fall] = lags.parameters.as_slice() else { return None };
    let alike = Estimate::of(rise).agrees(Estimate::of(fall));
    alike.then(|| "field_lag_asymmetry: rise and fall do not differ, so what is missing is no asymmetry".to_owned())
}

fn delayed_alike(nominal: &Physics, effects: &[EffectAnswer]) -> Option<String> {
    let torque = first(effects, "torque_delay")?.beyond(nominal.torque_delay_s);
    let field = first(effects, "field_dead_time")?.beyond(nominal_dead_time_s(nominal)?);
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

/// The balance of torques is fixed up to one scale: all of its terms but one off by the same factor are that one off.
fn one_scale(nominal: &Physics, effects: &[EffectAnswer], barred: &dyn Fn(&str) -> bool) -> Option<String> {
    let terms = [
        ("torque_gain", nominal.torque_gain),
        ("inertia", nominal.inertia),
        ("coulomb_friction", nominal.coulomb),
        ("viscous_friction", nominal.viscous),
        ("er_strength", nominal.damper.as_ref().map_or(0.0, |damper| damper.scale)),
    ];
    let terms = terms.iter().filter(|(_, size)| *size > 0.0);
    let (changed, same): (Vec<_>, Vec<_>) = terms.partition(|(id, _)| first(effects, id).is_some());
    let [(single, _)] = same.as_slice() else { return None };
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
            assert_eq!(coincidences(&problem(), &effects, &nominal(), &without(one)).len(), 1, "{one}");
            assert_eq!(coincidences(&problem(), &effects, &nominal(), &VOCABULARY), Vec::<String>::new(), "{one}");
        }
        let two = [effect("torque_delay", &[0.006]), effect("field_dead_time", &[0.0035])];
        assert!(coincidences(&problem(), &two, &nominal(), &without("sensor_latency")).is_empty());
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
        let found = coincidences(&problem(), &scaled(1.1), &nominal(), &without("torque_gain"));
        assert!(found.len() == 1 && found[0].contains("1.1000 times"), "{found:?}");
        assert!(coincidences(&problem(), &scaled(1.2), &nominal(), &without("torque_gain")).is_empty());
    }
}
