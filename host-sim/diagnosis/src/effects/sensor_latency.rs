//! The position is reported late: measured(t) = th(t - d); negative where commands are stamped late.

use super::{CURRENT_STEP, Effect, PLAIN, commanded, free, shown};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "sensor_latency",
    sentence: "Position and commands are not of the same instant: transport of the reading, or stamps set at another place of the cycle.",
    parameters: &[free(-0.05, 0.05, 1e-3)],
    applies: commanded,
    starts: |_, _| [-5e-3, -2e-3, -0.7e-3, 0.7e-3, 2e-3, 5e-3].iter().map(|&v| vec![v]).collect(),
    put: |p, v| p.model.sensor.latency_s = v[0],
    alike: &["torque_delay", "channel_skew"],
    measured_by: Some(CURRENT_STEP),
    example: shown(|f| vec![0.0012 * f]),
    ..PLAIN
};
