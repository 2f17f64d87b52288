//! A spring to position 0: -k th.

use super::{Columns, Effect, HOLDING, PLAIN, Size, shown, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "spring_load",
    sentence: "A force proportional to position: a cable, hose or return spring.",
    parameters: &[sized(Size::Stiffness, 0.0, 1e3, 0.05)],
    starts: |p, _| vec![vec![p.model.spring_stiffness]],
    put: |p, v| p.model.spring_stiffness = v[0],
    columns: Columns::Each,
    measured_by: Some(HOLDING),
    example: shown(|f| vec![0.6 * f]),
    ..PLAIN
};
