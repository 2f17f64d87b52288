//! The moving inertia.

use super::{Effect, Size, always, as_fitted, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "inertia",
    sentence: "The moving inertia is not nominal: payload, coupling or tooling, or a datasheet value without them.",
    parameters: &[sized(Size::Inertia, 0.3, 4.0, 0.05)],
    applies: always,
    starts: |p, _| vec![vec![1.05 * p.inertia]],
    put: |p, v| p.inertia = v[0],
    report: as_fitted,
};
