//! Dry friction: -c sign(w).

use super::{Effect, Size, always, as_fitted, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "coulomb_friction",
    sentence: "Dry friction is not at its nominal level: bearings, seals, preload, or a zero-field drag counted wrongly.",
    parameters: &[sized(Size::Torque, 0.0, 1e3, 0.05)],
    applies: always,
    starts: |p, e| vec![vec![p.coulomb + 0.05 * e.torque_rms]],
    put: |p, v| p.coulomb = v[0],
    report: as_fitted,
};
