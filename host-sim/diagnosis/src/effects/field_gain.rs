//! The field that acts is a gain times the commanded one.

use super::{Columns, Effect, PLAIN, VOLTAGE, free, shown, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "field_gain",
    sentence: "The field that acts is not the commanded one by a factor: calibration of the high-voltage amplifier, or a gap that is not nominal.",
    parameters: &[free(0.0, 5.0, 0.1)],
    applies: with_field,
    starts: |p, _| vec![vec![p.model.er.as_ref().map_or(1.0, |er| er.field_gain)]],
    put: |p, v| {
        if let Some(er) = &mut p.model.er {
            er.field_gain = v[0];
        }
    },
    neutral: |_| 1.0,
    columns: Columns::Each,
    measured_by: Some(VOLTAGE),
    example: shown(|f| vec![1.0 - 0.15 * f]),
    ..PLAIN
};
