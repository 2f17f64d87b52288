//! The torque that acts is the mean of the last commands: late and smooth, by neither a delay nor a lag.

use super::super::{Effect, PLAIN, commanded, free};

/// The hypothesis.
pub static EFFECT: Effect = Effect {
    id: "blurred_command",
    sentence: "the torque's command is late and smooth, in a way that is not told",
    parameters: &[free(0.0, 0.2, 1e-3)],
    applies: commanded,
    starts: |_, _| [1e-3, 3e-3, 8e-3].iter().map(|&v| vec![v]).collect(),
    put: |p, v| p.command_blur_s = v[0],
    nameable: false,
    ..PLAIN
};
