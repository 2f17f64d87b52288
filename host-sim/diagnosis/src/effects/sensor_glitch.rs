//! Isolated samples of the position are wrong by a size.

use super::{Effect, PLAIN, fixed};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "sensor_glitch",
    sentence: "Isolated position samples are wrong: disturbed transmission, a bit lost on the bus, a fault of the converter.",
    parameters: &[fixed(), fixed()],
    applies: |_, _| false,
    starts: |_, _| Vec::new(),
    put: |_, _| {},
    ..PLAIN
};
