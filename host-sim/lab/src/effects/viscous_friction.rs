//! Friction linear in speed: -B w.

use super::{Effect, Size, always, as_fitted, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "viscous_friction",
    sentence: "Friction linear in speed is not at its nominal value: lubricant, zero-field viscosity of the fluid, eddy currents, back EMF.",
    parameters: &[sized(Size::Damping, 0.0, 1e3, 0.05)],
    applies: always,
    starts: |p, e| vec![vec![p.viscous + 0.05 * e.torque_rms / e.speed_peak.max(1e-9)]],
    put: |p, v| p.viscous = v[0],
    report: as_fitted,
};
