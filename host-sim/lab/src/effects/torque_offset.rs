//! The drive adds a constant torque.

use super::{Effect, Size, always, as_fitted, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "torque_offset",
    sentence: "A constant torque is added: offset of the current sensor or DAC, or a constant load.",
    parameters: &[sized(Size::Torque, -1e2, 1e2, 0.05)],
    applies: always,
    starts: |p, e| vec![vec![p.torque_offset + 0.05 * e.torque_rms]],
    put: |p, v| p.torque_offset = v[0],
    report: as_fitted,
};
