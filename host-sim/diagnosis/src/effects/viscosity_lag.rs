//! The coefficient of viscosity follows with a first-order lag: torque Q_d |w|.

use plant::FluidResponse;

use crate::physics::Physics;

use super::{Effect, PLAIN, free, shown_as_another, strongest, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "viscosity_lag",
    sentence: "The coefficient of viscosity, not the field, lags: the fluid as the paper's Q models see it.",
    parameters: &[free(0.0, 0.2, 1e-3)],
    applies: with_field,
    // Less than a substep moves nothing, so that none is no way to a short one.
    starts: |_, e| [0.0, 0.5 * e.period_s, 2e-3, 5e-3, 10e-3, 20e-3].iter().map(|&v| vec![v]).collect(),
    put: |p, v| {
        if let Some(er) = &mut p.model.er {
            er.response = FluidResponse::ViscosityLag { lag_s: v[0], torque_limit: strongest(er) };
        }
    },
    neutral: no_delay_of_viscosity,
    example: shown_as_another(|_| vec![0.005]),
    ..PLAIN
};

/// The delay of a viscosity on a machine without such an effect: where the field is late in its place, no delay is one, for with it nothing
/// is late.
pub(super) fn no_delay_of_viscosity(physics: &Physics) -> f64 {
    let late = physics.field().is_some_and(|field| field.dead_time_s + field.rise_s + field.fall_s > 0.0);
    if late { f64::NEG_INFINITY } else { 0.0 }
}
