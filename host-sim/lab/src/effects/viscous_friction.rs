//! Friction linear in speed: -B w.

use super::{Effect, always, as_fitted, free};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "viscous_friction",
    sentence: "Friction linear in speed is not at its nominal value: lubricant, zero-field viscosity of the fluid, eddy currents, back EMF.",
    parameters: &[free(0.0, 1e9, 0.1)],
    applies: always,
    starts: |p, e| vec![vec![p.viscous + 0.05 * e.torque_rms / e.speed_peak.max(1e-9)]],
    put: |p, v| p.viscous = v[0],
    report: as_fitted,
};
