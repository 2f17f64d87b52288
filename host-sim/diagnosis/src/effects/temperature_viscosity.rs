//! Viscous friction that falls with the heat in it: B exp(-k H), dH/dt = P - r H, P the power of all drag.

use plant::effects::Warming;

use super::{Effect, PLAIN, Size, sized};

/// The entry of the vocabulary. Each recording begins cold, at the nominal coefficient.
pub static EFFECT: Effect = Effect {
    id: "temperature_viscosity",
    sentence: "Viscous friction falls as its own power warms the lubricant or the fluid, and comes back as that cools.",
    parameters: &[sized(Size::PerWork, 0.0, 1e3, 0.1), sized(Size::PerDuration, 0.0, 1e3, 1.0)],
    applies: |p, _| p.model.viscous > 0.0,
    starts: |p, e| {
        let (per_j, per_s) = (Size::PerWork.of(p, e), Size::PerDuration.of(p, e));
        [(1.0, 0.3), (1.0, 3.0), (5.0, 3.0), (5.0, 30.0)].iter().map(|(k, r)| vec![k * per_j, r * per_s]).collect()
    },
    put: |p, v| p.model.viscous_warming = Some(Warming { per_j: v[0], cooling_per_s: v[1] }),
    ..PLAIN
};
