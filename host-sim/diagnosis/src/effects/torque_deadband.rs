//! Commands within a band give nothing, those outside lose the band.

use super::{Effect, PLAIN, Size, commanded, shown, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "torque_deadband",
    sentence: "Small torque commands do nothing: dead time of the bridge, or a dead-band in the drive's input.",
    parameters: &[sized(Size::Torque, 0.0, 0.5, 0.02)],
    applies: commanded,
    starts: |_, e| [0.02, 0.05, 0.15].iter().map(|&v| vec![v * e.torque_rms]).collect(),
    put: |p, v| p.model.torque_deadband = v[0],
    example: shown(|f| vec![0.3 * f]),
    ..PLAIN
};
