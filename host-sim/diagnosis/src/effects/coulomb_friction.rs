//! Dry friction: -c sign(w).

use super::{Columns, Effect, PLAIN, Size, shown, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "coulomb_friction",
    sentence: "Dry friction is not at its nominal level: bearings, seals, preload, or a zero-field drag counted wrongly.",
    parameters: &[sized(Size::Torque, 0.0, 1e3, 0.05)],
    starts: |p, _| vec![vec![p.model.coulomb]],
    put: |p, v| p.model.coulomb = v[0],
    neutral: |p| p.model.coulomb,
    columns: Columns::Each,
    example: shown(|f| vec![0.763 + 0.19 * f]),
    ..PLAIN
};
