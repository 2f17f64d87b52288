//! Effects that may be none.

use crate::effects::Physics;
use crate::report::EffectAnswer;

/// In words, which effects of an answer have an interval that holds the machine as it was: what is missing needs them to be
/// predicted, and does not say that they are there, so they stand for something else.
pub(super) fn coincidences(nominal: &Physics, effects: &[EffectAnswer]) -> Vec<String> {
    let none = effects.iter().filter(|effect| {
        let value = effect.parameters.first().zip(unchanged(nominal, &effect.id));
        value.is_some_and(|(size, nominal)| size.low <= nominal && nominal <= size.high)
    });
    none.map(|effect| format!("{}: its interval holds the machine as it was, and yet it is needed", effect.id))
        .collect()
}

/// The first value of an effect on a machine that has none of it; none where no single value says that.
fn unchanged(nominal: &Physics, id: &str) -> Option<f64> {
    let damper = nominal.damper.as_ref();
    match id {
        "field_dead_time" => damper.map(|damper| damper.dead_time_s),
        "field_gain" => damper.map(|damper| damper.gain),
        "er_strength" => damper.map(|damper| damper.scale),
        "er_drift" => damper.map(|damper| damper.drift_per_s),
        "coulomb_friction" => Some(nominal.coulomb),
        "viscous_friction" => Some(nominal.viscous),
        "stribeck_friction" => Some(nominal.stribeck_excess),
        "torque_gain" => Some(nominal.torque_gain),
        "torque_offset" => Some(nominal.torque_offset),
        "torque_deadband" => Some(nominal.torque_deadband),
        "torque_delay" => Some(nominal.torque_delay_s),
        "torque_lag" => Some(nominal.torque_lag_s),
        "inertia" => Some(nominal.inertia),
        "spring_load" => Some(nominal.spring),
        "quadratic_drag" => Some(nominal.quadratic),
        "sensor_latency" => Some(nominal.latency_s),
        _ => None,
    }
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
