//! The moving inertia.

use super::{Columns, Effect, PLAIN, Size, WEIGH, shown, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "inertia",
    sentence: "The moving inertia is not nominal: payload, coupling or tooling, or a datasheet value without them.",
    // A load or a gear that a datasheet does not know is ten times a motor.
    parameters: &[sized(Size::Inertia, 0.1, 10.0, 0.05)],
    starts: |p, _| vec![vec![p.model.inertia]],
    put: |p, v| p.model.inertia = v[0],
    neutral: |p| p.model.inertia,
    columns: Columns::Each,
    measured_by: Some(WEIGH),
    example: shown(|f| vec![0.075 + 0.007 * f]),
    ..PLAIN
};
