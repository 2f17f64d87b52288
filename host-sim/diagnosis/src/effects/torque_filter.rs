//! The torque column is a measurement behind a first-order filter: tau dT_m/dt = T - T_m.

use super::{CURRENT_STEP, Effect, PLAIN, free, measured};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "torque_filter",
    sentence: "The torque column is a measurement behind a filter, not what acts: the drive's filtered current.",
    parameters: &[free(0.0, 1.0, 1e-3)],
    applies: measured,
    starts: |_, e| [1.0, 3.0, 10.0, 30.0, 100.0].iter().map(|&rows| vec![rows * e.period_s]).collect(),
    put: |p, v| p.torque_filter_s = v[0],
    measured_by: Some(CURRENT_STEP),
    ..PLAIN
};
