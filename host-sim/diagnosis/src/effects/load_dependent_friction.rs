//! Dry friction that grows with the torque that is transmitted: level + k |drive torque|.

use super::{Columns, Effect, PLAIN, commanded, free, shown};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "load_dependent_friction",
    sentence: "Friction grows with the torque that is transmitted: a gear, screw or bearing that its load presses together.",
    // From 1 on no torque would move the rotor.
    parameters: &[free(0.0, 0.9, 0.02)],
    // Of a measured torque it would mostly say that less was measured: there it took the place of the published Coulomb and viscous friction
    // of two real robots (prove --real, dfki and weigand j6).
    applies: commanded,
    starts: |p, _| vec![vec![p.model.load_friction]],
    put: |p, v| p.model.load_friction = v[0],
    neutral: |p| p.model.load_friction,
    columns: Columns::Each,
    example: shown(|f| vec![0.1 * f]),
    ..PLAIN
};
