//! Isolated samples of the position are wrong by a size.

use super::{Effect, PLAIN, Parameter, Size, searched};

/// More than a rounded sample and its neighbours are off by, and less than any travel.
const OFF: Parameter = Parameter { size: Size::Step, ..searched(4.0, 1e9) };

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "sensor_glitch",
    sentence: "Isolated position samples are wrong: disturbed transmission, a bit lost on the bus, a fault of the converter.",
    parameters: &[searched(1e-6, 0.2), OFF],
    starts: |_, e| e.glitch.iter().map(|&(fraction, size)| vec![fraction, size.max(OFF.low * e.step)]).collect(),
    put: |p, v| p.glitch = Some((v[0], v[1])),
    once: true,
    ..PLAIN
};
