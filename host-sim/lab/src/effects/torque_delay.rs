//! The commanded torque acts after a delay.

use super::{Effect, always, as_fitted, free};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "torque_delay",
    sentence: "The torque acts later or earlier than the model says: communication, computation, or a sample of the current loop.",
    parameters: &[free(0.0, 0.1, 1e-3)],
    applies: always,
    starts: |p, _| {
        let d = p.torque_delay_s;
        [0.0, d - 2e-3, d - 0.7e-3, d + 0.7e-3, d + 2e-3, d + 5e-3, d + 12e-3]
            .iter()
            .filter(|&&v| v >= 0.0)
            .map(|&v| vec![v])
            .collect()
    },
    put: |p, v| p.torque_delay_s = v[0],
    report: as_fitted,
};
