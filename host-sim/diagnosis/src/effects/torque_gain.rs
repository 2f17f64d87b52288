//! The drive gives a gain times the commanded torque.

use super::{Columns, Effect, PLAIN, WEIGH, free, shown};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "torque_gain",
    sentence: "The drive gives another torque than commanded by a factor: torque constant, current-sensor or DAC calibration, magnet temperature.",
    parameters: &[free(0.3, 3.0, 0.05)],
    starts: |p, _| vec![vec![p.model.torque_gain]],
    put: |p, v| p.model.torque_gain = v[0],
    neutral: |p| p.model.torque_gain,
    columns: Columns::Each,
    measured_by: Some(WEIGH),
    example: shown(|f| vec![1.0 - 0.07 * f]),
    ..PLAIN
};
