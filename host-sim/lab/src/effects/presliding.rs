//! Dry friction as a bristle (Dahl): dF/dx = k (1 - F/c sign(w)).

use super::{Effect, as_fitted, free};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "presliding",
    sentence: "Dry friction gives like a spring before it slides: asperities or balls that roll elastically.",
    parameters: &[free(1.0, 1e9, 50.0)],
    applies: |p, _| p.coulomb > 0.0,
    starts: |p, _| [0.0003, 0.001, 0.003, 0.01, 0.03].iter().map(|&v| vec![p.coulomb / v]).collect(),
    put: |p, v| p.presliding = v[0],
    report: as_fitted,
};
