//! Excess over Coulomb at low speed: -x exp(-(w/v)^2) sign(w).

use plant::effects::Stribeck;

use super::{Effect, PLAIN, Size, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "stribeck_friction",
    sentence: "Friction rises towards standstill (Stribeck): boundary lubrication in bearings and seals.",
    parameters: &[sized(Size::Torque, 0.0, 1e2, 0.05), sized(Size::Speed, 1e-3, 1.0, 0.02)],
    starts: |_, e| {
        [0.01, 0.03, 0.1, 0.3].iter().map(|&v| vec![0.05 * e.torque_rms, v * e.speed_peak.max(1e-3)]).collect()
    },
    put: |p, v| p.model.stribeck = Some(Stribeck { excess: v[0], velocity: v[1] }),
    ..PLAIN
};
