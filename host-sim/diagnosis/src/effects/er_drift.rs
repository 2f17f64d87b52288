//! The electrorheological torque times 1 + r t.

use super::{Columns, Effect, PLAIN, VOLTAGE, free, shown, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "er_drift",
    sentence: "The fluid's torque drifts with time: warming by its own friction and leakage current.",
    parameters: &[free(-1.0, 1.0, 0.01)],
    applies: with_field,
    starts: |_, _| vec![vec![0.0]],
    put: |p, v| {
        if let Some(er) = &mut p.model.er {
            er.drift_per_s = v[0];
        }
    },
    columns: Columns::Each,
    measured_by: Some(VOLTAGE),
    example: shown(|f| vec![-0.03 * f]),
    ..PLAIN
};
