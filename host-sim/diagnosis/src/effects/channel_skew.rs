//! The torque column is stamped another time than the position column: two loggers, or a measurement that passes a bus.

use super::{CURRENT_STEP, Effect, PLAIN, free, may_be_skewed};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "channel_skew",
    sentence: "Torque and position are stamped at different times: channels of two devices, or a measurement that passes a bus.",
    parameters: &[free(-0.05, 0.05, 1e-3)],
    applies: may_be_skewed,
    starts: |_, e| [-3.0, -1.0, -0.5, 0.5, 1.0, 3.0].iter().map(|&rows| vec![rows * e.period_s]).collect(),
    put: |p, v| p.skew_s = v[0],
    alike: &["torque_delay", "sensor_latency"],
    // One that is stamped late acts before its row, which no delay does.
    alike_beside_a_fluid: |v| if v[0] > 0.0 { &["torque_delay"] } else { &[] },
    first: true,
    measured_by: Some(CURRENT_STEP),
    ..PLAIN
};
