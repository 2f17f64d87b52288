//! Drag that grows with the square of speed: -k w |w|.

use super::{Columns, Effect, PLAIN, Size, shown, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "quadratic_drag",
    sentence: "Drag grows with the square of speed: windage, or churning of a fluid.",
    parameters: &[sized(Size::Drag, 0.0, 1e2, 0.05)],
    starts: |p, _| vec![vec![p.model.quadratic_drag]],
    put: |p, v| p.model.quadratic_drag = v[0],
    columns: Columns::Each,
    example: shown(|f| vec![0.1 * f]),
    ..PLAIN
};
