//! A load on a flexible shaft: part of the inertia follows through a spring and a damper.

use plant::effects::Shaft;

use super::{Effect, LOAD_SIDE, PLAIN, Parameter, Size, free, shown_by, sized};

/// Up to a quarter of the sample rate: four samples a period show it.
const RESONANCE: Parameter = sized(Size::Rate, 1e-4, 0.25, 2.5e-3);

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "compliance",
    sentence: "Part of the inertia hangs on a flexible shaft or coupling and resonates.",
    parameters: &[RESONANCE, free(1e-3, 1.0, 0.02), free(1e-2, 5.0, 0.1)],
    starts: |_, e| {
        // Where the residual rings, and a step of a half from one to the next elsewhere.
        let rings = e.tones.iter().map(|tone| tone.frequency_hz);
        let all = rings.chain([6.0, 10.0, 15.0, 22.0, 32.0, 45.0, 65.0, 95.0, 140.0]);
        all.map(|frequency_hz| vec![frequency_hz, 0.05, 0.5]).collect()
    },
    put: |p, v| p.model.shaft = Some(Shaft { resonance_hz: v[0], damping_ratio: v[1], inertia_ratio: v[2], gap: 0.0 }),
    measured_by: Some(LOAD_SIDE),
    remembers: true,
    // A shaft of no compliance would resonate at infinity; 40 Hz with a load that grows.
    example: shown_by(2, |f| vec![40.0, 0.03, 0.4 * f]),
    ..PLAIN
};
