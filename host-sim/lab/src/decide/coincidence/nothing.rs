//! Effects that may be none.

use super::unchanged;
use crate::effects::Physics;
use crate::report::EffectAnswer;

/// Effects whose first value alone says how much of them there is.
const SIZED: [&str; 16] = [
    "field_dead_time",
    "field_gain",
    "er_strength",
    "er_drift",
    "coulomb_friction",
    "viscous_friction",
    "stribeck_friction",
    "torque_gain",
    "torque_offset",
    "torque_deadband",
    "torque_delay",
    "torque_lag",
    "inertia",
    "spring_load",
    "quadratic_drag",
    "sensor_latency",
];

/// In words, which effects of an answer have an interval that holds the machine as it was: what is missing needs them to be
/// predicted, and does not say that they are there, so they stand for something else.
pub(super) fn coincidences(nominal: &Physics, effects: &[EffectAnswer]) -> Vec<String> {
    let sized = effects.iter().filter(|effect| SIZED.contains(&effect.id.as_str()));
    let none = sized.filter(|effect| {
        let value = effect.parameters.first().zip(unchanged(nominal, &effect.id));
        value.is_some_and(|(size, nominal)| size.low <= nominal && nominal <= size.high)
    });
    none.map(|effect| format!("{}: its interval holds the machine as it was, and yet it is needed", effect.id))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{effect, nominal};
    use super::*;

    #[test]
    fn an_effect_whose_interval_holds_the_nominal_value_may_be_none() {
        let with = |low: f64| {
            let mut excess = effect("stribeck_friction", &[0.02, 0.5]);
            if let Some(size) = excess.parameters.first_mut() {
                size.low = low;
            }
            coincidences(&nominal(), &[excess])
        };
        assert_eq!((with(0.0).len(), with(0.01).len()), (1, 0));
        // A phase or a start time may be zero.
        assert!(coincidences(&nominal(), &[effect("disturbance_pulse", &[0.0, 0.1, 2.0])]).is_empty());
    }
}
