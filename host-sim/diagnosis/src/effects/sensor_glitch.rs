//! Isolated samples of the position are wrong by a size.

use super::{Effect, PLAIN, searched};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "sensor_glitch",
    sentence: "Isolated position samples are wrong: disturbed transmission, a bit lost on the bus, a fault of the converter.",
    parameters: &[searched(1e-6, 0.2), searched(0.0, 1.0)],
    starts: |_, e| e.glitch.iter().map(|&(fraction, size)| vec![fraction, size]).collect(),
    put: |p, v| p.glitch = Some((v[0], v[1])),
    ..PLAIN
};
