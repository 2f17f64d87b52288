//! First-order lag of the torque: tau dT/dt = T_cmd - T.

use super::{CURRENT_STEP, Effect, PLAIN, commanded, free, shown};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "torque_lag",
    sentence: "The torque follows its command with a first-order lag: bandwidth of the current loop.",
    parameters: &[free(0.0, 0.2, 1e-3)],
    applies: commanded,
    starts: |_, _| [0.5e-3, 1.5e-3, 4e-3, 10e-3].iter().map(|&v| vec![v]).collect(),
    put: |p, v| p.model.torque_lag_s = v[0],
    measured_by: Some(CURRENT_STEP),
    example: shown(|f| vec![0.0015 * f]),
    ..PLAIN
};
