//! Dry friction: -c sign(w).

use super::{Effect, PLAIN, Size, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "coulomb_friction",
    sentence: "Dry friction is not at its nominal level: bearings, seals, preload, or a zero-field drag counted wrongly.",
    parameters: &[sized(Size::Torque, 0.0, 1e3, 0.05)],
    starts: |p, e| vec![vec![p.model.coulomb + 0.05 * e.torque_rms]],
    put: |p, v| p.model.coulomb = v[0],
    neutral: |p| p.model.coulomb,
    ..PLAIN
};
