//! Dry friction as a bristle (Dahl): dF/dx = k (1 - F/c sign(w)).

use super::{Effect, PLAIN, Size, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "presliding",
    sentence: "Dry friction gives like a spring before it slides: asperities or balls that roll elastically.",
    parameters: &[sized(Size::Stiffness, 1.0, 1e7, 10.0)],
    applies: |p, _| p.model.coulomb > 0.0,
    starts: |p, _| [0.0003, 0.001, 0.003, 0.01, 0.03].iter().map(|&v| vec![p.model.coulomb / v]).collect(),
    put: |p, v| p.model.presliding_stiffness = Some(v[0]),
    neutral: |_| f64::INFINITY,
    remembers: true,
    ..PLAIN
};
