//! Friction linear in speed: -B w.

use super::{Columns, Effect, PLAIN, Size, shown, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "viscous_friction",
    sentence: "Friction linear in speed is not at its nominal value: lubricant, zero-field viscosity of the fluid, eddy currents, back EMF.",
    parameters: &[sized(Size::Damping, 0.0, 1e3, 0.05)],
    starts: |p, _| vec![vec![p.model.viscous]],
    put: |p, v| p.model.viscous = v[0],
    neutral: |p| p.model.viscous,
    columns: Columns::Each,
    example: shown(|f| vec![0.15 * f]),
    ..PLAIN
};
