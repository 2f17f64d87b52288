//! Below yield the fluid is a spring: a bristle of that stiffness, limited by the electrorheological torque.

use std::f64::consts::TAU;

use super::{Effect, PLAIN, Size, shown, sized, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "er_preyield",
    sentence: "Below its yield stress the fluid gives like a spring: chains of particles stretch before they break.",
    parameters: &[sized(Size::Stiffness, 1.0, 1e7, 10.0)],
    applies: with_field,
    // By where rotor and spring ring, an octave apart, up to what the samples show of it.
    starts: |p, e| {
        let hz = [2.5, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0].into_iter().filter(|hz| 4.0 * hz * e.period_s < 1.0);
        hz.map(|hz| vec![p.model.inertia * (TAU * hz).powi(2)]).collect()
    },
    put: |p, v| {
        if let Some(er) = &mut p.model.er {
            er.preyield_stiffness = Some(v[0]);
        }
    },
    neutral: |_| f64::INFINITY,
    remembers: true,
    example: shown(|f| vec![300.0 / f]),
    ..PLAIN
};
