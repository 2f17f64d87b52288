//! The coefficient of viscosity acts after a dead time: torque Q(t - d) |w|.

use plant::FluidResponse;

use super::viscosity_lag::no_delay_of_viscosity;
use super::{Effect, PLAIN, free, shown_as_another, strongest, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "viscosity_dead_time",
    sentence: "The coefficient of viscosity, not the field, acts late: the fluid as the paper's Q models see it.",
    parameters: &[free(0.0, 0.2, 1e-3)],
    applies: with_field,
    // Less than a substep moves nothing, so that none is no way to a short one.
    starts: |_, e| [0.0, 0.5 * e.period_s, 2e-3, 5e-3, 10e-3, 20e-3, 50e-3].iter().map(|&v| vec![v]).collect(),
    put: |p, v| {
        if let Some(er) = &mut p.model.er {
            er.response = FluidResponse::ViscosityDeadTime { dead_time_s: v[0], torque_limit: strongest(er) };
        }
    },
    neutral: no_delay_of_viscosity,
    example: shown_as_another(|_| vec![0.005]),
    ..PLAIN
};
