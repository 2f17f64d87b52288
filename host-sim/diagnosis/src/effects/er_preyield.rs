//! Below yield the fluid is a spring: a bristle of that stiffness, limited by the electrorheological torque.

use super::{Effect, PLAIN, free, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "er_preyield",
    sentence: "Below its yield stress the fluid gives like a spring: chains of particles stretch before they break.",
    parameters: &[free(1.0, 1e6, 50.0)],
    applies: with_field,
    starts: |_, _| [1000.0, 400.0, 150.0, 60.0, 20.0].iter().map(|&v| vec![v]).collect(),
    put: |p, v| {
        if let Some(er) = &mut p.model.er {
            er.preyield_stiffness = Some(v[0]);
        }
    },
    neutral: |_| f64::INFINITY,
    remembers: true,
    ..PLAIN
};
