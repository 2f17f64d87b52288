//! The commanded field acts after a dead time: E_d(t) = E(t - d).

use super::{Effect, PLAIN, free, shown, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "field_dead_time",
    sentence: "The field acts after a dead time: computation, transport in the high-voltage amplifier, or the fluid's own response.",
    parameters: &[free(0.0, 0.05, 1e-3)],
    applies: with_field,
    starts: |p, _| {
        let d = p.field().map_or(0.0, |field| field.dead_time_s);
        [0.0, d, d + 1e-3, d + 2e-3, d + 4e-3, d + 8e-3, d + 15e-3].iter().map(|&v| vec![v]).collect()
    },
    put: |p, v| {
        p.with_field(|field| field.dead_time_s = v[0]);
    },
    neutral: |p| p.field().map_or(0.0, |field| field.dead_time_s),
    example: shown(|f| vec![0.002 + 0.003 * f]),
    ..PLAIN
};
