//! Drag that grows with the square of speed: -k w |w|.

use super::{Effect, always, as_fitted, free};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "quadratic_drag",
    sentence: "Drag grows with the square of speed: windage, or churning of a fluid.",
    parameters: &[free(0.0, 1e9, 0.1)],
    applies: always,
    starts: |_, e| vec![vec![0.05 * e.torque_rms / e.speed_peak.powi(2).max(1e-12)]],
    put: |p, v| p.quadratic = v[0],
    report: as_fitted,
};
