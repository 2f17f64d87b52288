//! What a field adds to the flow of the fluid: drag k_E E |w|^n on top of a E^2 + b E (Herschel and Bulkley).
//!
//! What flows without a field is viscous friction to a motion, and an effect of its own.

use plant::er_fluid::{FlowCurve, LEAST_EXPONENT};

use super::{Effect, PLAIN, Size, commanded, free, shown, sized, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "er_flow",
    sentence: "Under a field the fluid drags the more the faster it is sheared, less than in proportion: particles hang together while the fluid flows.",
    parameters: &[sized(Size::Damping, 0.0, 1e3, 0.02), free(LEAST_EXPONENT, 1.0, 0.1)],
    applies: |p, e| with_field(p, e) && commanded(p, e) && p.field().is_some(),
    starts: |p, e| {
        let size = Size::Damping.of(p, e);
        [(0.05, 1.0), (0.05, 0.5), (0.05, 0.25), (0.2, 1.0), (0.2, 0.5)]
            .iter()
            .map(|(k, n)| vec![k * size, *n])
            .collect()
    },
    put: |p, v| {
        let curve = FlowCurve { consistency: 0.0, consistency_per_kv_mm: v[0], exponent: v[1] };
        p.with_field(|field| field.flow = Some(curve));
    },
    example: shown(|f| vec![0.05 * f, 0.5]),
    ..PLAIN
};
