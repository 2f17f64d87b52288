//! First-order lag of the field: tau dE_d/dt = E - E_d.

use super::{Effect, PLAIN, free, shown, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "field_lag",
    sentence: "The field builds up with a first-order lag: charging of the electrodes through the amplifier, or polarisation of the fluid.",
    parameters: &[free(0.0, 0.2, 1e-3)],
    applies: with_field,
    starts: |p, _| {
        let d = p.field().map_or(0.0, |field| field.rise_s);
        [0.0, 0.5 * d, d + 1e-3, d + 2e-3, d + 4e-3, d + 8e-3, d + 16e-3, d + 40e-3].iter().map(|&v| vec![v]).collect()
    },
    put: |p, v| {
        p.with_field(|field| (field.rise_s, field.fall_s) = (v[0], v[0]));
    },
    neutral: |p| p.field().map_or(0.0, |field| field.rise_s),
    example: shown(|f| vec![0.003 + 0.005 * f]),
    ..PLAIN
};
