//! The electrorheological torque falls with the heat in it: (a E^2 + b E) exp(-k H), dH/dt = P - r H, P the power of all drag.

use plant::effects::Warming;

use super::{Effect, PLAIN, Size, VOLTAGE, shown, sized, with_field};

/// The entry of the vocabulary. Each recording begins cold, at the nominal strength.
pub static EFFECT: Effect = Effect {
    id: "temperature_yield",
    sentence: "The fluid yields less as the power of the drag warms it, and holds again as it cools.",
    parameters: &[sized(Size::PerWork, 0.0, 1e3, 0.1), sized(Size::PerDuration, 0.0, 1e3, 1.0)],
    applies: with_field,
    starts: |p, e| {
        let (per_j, per_s) = (Size::PerWork.of(p, e), Size::PerDuration.of(p, e));
        [(1.0, 0.3), (1.0, 3.0), (5.0, 3.0), (5.0, 30.0)].iter().map(|(k, r)| vec![k * per_j, r * per_s]).collect()
    },
    put: |p, v| {
        if let Some(er) = &mut p.model.er {
            er.warming = Some(Warming { per_j: v[0], cooling_per_s: v[1] });
        }
    },
    measured_by: Some(VOLTAGE),
    example: shown(|f| vec![0.02 * f, 0.1]),
    ..PLAIN
};
