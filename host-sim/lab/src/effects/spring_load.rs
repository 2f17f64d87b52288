//! A spring to position 0: -k th.

use super::{Effect, always, as_fitted, free};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "spring_load",
    sentence: "A force proportional to position: a cable, hose or return spring.",
    parameters: &[free(0.0, 1e9, 1.0)],
    applies: always,
    starts: |_, e| vec![vec![0.05 * e.torque_rms / e.travel.max(1e-9)]],
    put: |p, v| p.spring = v[0],
    report: as_fitted,
};
