//! The drive gives a gain times the commanded torque.

use super::{Effect, always, as_fitted, free};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "torque_gain",
    sentence: "The drive gives another torque than commanded by a factor: torque constant, current-sensor or DAC calibration, magnet temperature.",
    parameters: &[free(0.3, 3.0, 0.05)],
    applies: always,
    starts: |p, _| vec![vec![1.05 * p.torque_gain]],
    put: |p, v| p.torque_gain = v[0],
    report: as_fitted,
};
