//! Friction linear in speed: -B w.

use super::{Effect, PLAIN, Size, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "viscous_friction",
    sentence: "Friction linear in speed is not at its nominal value: lubricant, zero-field viscosity of the fluid, eddy currents, back EMF.",
    parameters: &[sized(Size::Damping, 0.0, 1e3, 0.05)],
    starts: |p, e| vec![vec![p.model.viscous + 0.05 * e.torque_rms / e.speed_peak.max(1e-9)]],
    put: |p, v| p.model.viscous = v[0],
    neutral: |p| p.model.viscous,
    ..PLAIN
};
