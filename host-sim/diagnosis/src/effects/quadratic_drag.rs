//! Drag that grows with the square of speed: -k w |w|.

use super::{Effect, PLAIN, Size, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "quadratic_drag",
    sentence: "Drag grows with the square of speed: windage, or churning of a fluid.",
    parameters: &[sized(Size::Drag, 0.0, 1e2, 0.05)],
    starts: |_, e| vec![vec![0.05 * e.torque_rms / e.speed_peak.powi(2).max(1e-12)]],
    put: |p, v| p.model.quadratic_drag = v[0],
    ..PLAIN
};
