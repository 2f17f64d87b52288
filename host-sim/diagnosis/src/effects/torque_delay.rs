//! The commanded torque acts after a delay.

use super::{CURRENT_STEP, Effect, PLAIN, commanded, free, shown};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "torque_delay",
    sentence: "The torque acts later or earlier than the model says: communication, computation, or a sample of the current loop.",
    parameters: &[free(0.0, 0.1, 1e-3)],
    applies: commanded,
    starts: |p, _| {
        let d = p.model.torque_delay_s;
        [0.0, d - 2e-3, d - 0.7e-3, d + 0.7e-3, d + 2e-3, d + 5e-3, d + 12e-3]
            .iter()
            .filter(|&&v| v >= 0.0)
            .map(|&v| vec![v])
            .collect()
    },
    put: |p, v| p.model.torque_delay_s = v[0],
    neutral: |p| p.model.torque_delay_s,
    alike: &["sensor_latency", "channel_skew"],
    alike_beside_a_fluid: |_| &["channel_skew"],
    measured_by: Some(CURRENT_STEP),
    example: shown(|f| vec![0.005 + 0.0012 * f]),
    ..PLAIN
};
