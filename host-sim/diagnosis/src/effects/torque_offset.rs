//! The drive adds a constant torque.

use super::{Columns, Effect, HOLDING, PLAIN, Size, shown, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "torque_offset",
    sentence: "A constant torque is added: offset of the current sensor or DAC, or a constant load.",
    parameters: &[sized(Size::Torque, -1e2, 1e2, 0.05)],
    starts: |p, _| vec![vec![p.model.torque_offset]],
    put: |p, v| p.model.torque_offset = v[0],
    neutral: |p| p.model.torque_offset,
    columns: Columns::Each,
    measured_by: Some(HOLDING),
    example: shown(|f| vec![0.2 * f]),
    ..PLAIN
};
