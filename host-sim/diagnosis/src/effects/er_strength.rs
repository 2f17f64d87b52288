//! The electrorheological torque times a scale: s (a E^2 + b E).

use super::{Effect, PLAIN, free, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "er_strength",
    sentence: "The fluid gives another torque than its law says by a factor: temperature, settling or ageing of the fluid.",
    parameters: &[free(0.0, 10.0, 0.1)],
    applies: with_field,
    starts: |_, _| [0.7, 1.3].iter().map(|&v| vec![v]).collect(),
    put: |p, v| {
        if let Some(er) = &mut p.model.er {
            er.scale = v[0];
        }
    },
    neutral: |_| 1.0,
    ..PLAIN
};
