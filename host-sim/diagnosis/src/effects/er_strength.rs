//! The electrorheological torque times a scale: s (a E^2 + b E).

use super::{Columns, Effect, PLAIN, VOLTAGE, free, shown, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "er_strength",
    sentence: "The fluid gives another torque than its law says by a factor: temperature, settling or ageing of the fluid.",
    parameters: &[free(0.0, 10.0, 0.1)],
    applies: with_field,
    starts: |p, _| vec![vec![p.model.er.as_ref().map_or(1.0, |er| er.scale)]],
    put: |p, v| {
        if let Some(er) = &mut p.model.er {
            er.scale = v[0];
        }
    },
    neutral: |_| 1.0,
    columns: Columns::Each,
    measured_by: Some(VOLTAGE),
    example: shown(|f| vec![1.0 - 0.2 * f]),
    ..PLAIN
};
