//! The field that acts is a gain times the commanded one.

use super::{Effect, PLAIN, free, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "field_gain",
    sentence: "The field that acts is not the commanded one by a factor: calibration of the high-voltage amplifier, or a gap that is not nominal.",
    parameters: &[free(0.0, 5.0, 0.1)],
    applies: with_field,
    starts: |_, _| [0.7, 0.9, 1.1, 1.4].iter().map(|&v| vec![v]).collect(),
    put: |p, v| {
        if let Some(er) = &mut p.model.er {
            er.field_gain = v[0];
        }
    },
    neutral: |_| 1.0,
    ..PLAIN
};
