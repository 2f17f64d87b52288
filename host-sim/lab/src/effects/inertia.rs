//! The moving inertia.

use super::{Effect, always, as_fitted, free};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "inertia",
    sentence: "The moving inertia is not nominal: payload, coupling or tooling, or a datasheet value without them.",
    parameters: &[free(1e-9, 1e9, 0.01)],
    applies: always,
    starts: |p, _| vec![vec![1.05 * p.inertia]],
    put: |p, v| p.inertia = v[0],
    report: as_fitted,
};
