//! Excess over Coulomb at low speed: -x exp(-(w/v)^2) sign(w).

use plant::effects::Stribeck;

use super::{Effect, PLAIN, Parameter, Size, gives_way, shown, sized};

/// Up to a quarter of the largest speed: mixed lubrication ends at a small share of a machine's speed (Armstrong-Hélouvry, Dupont
/// and Canudas de Wit 1994: 1e-5 to 0.1 m/s); a curve that bends over all of it is another friction.
const VELOCITY: Parameter = sized(Size::Speed, 1e-3, 0.25, 0.02);

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "stribeck_friction",
    sentence: "Friction rises towards standstill (Stribeck): boundary lubrication in bearings and seals.",
    parameters: &[sized(Size::Torque, 0.0, 1e2, 0.05), VELOCITY],
    starts: |_, e| {
        [0.01, 0.03, 0.1, 0.2].iter().map(|&v| vec![0.05 * e.torque_rms, v * e.speed_peak.max(1e-3)]).collect()
    },
    put: |p, v| p.model.stribeck = Some(Stribeck { excess: v[0], velocity: v[1] }),
    explains: gives_way,
    example: shown(|f| vec![0.5 * f, 0.1]),
    ..PLAIN
};
