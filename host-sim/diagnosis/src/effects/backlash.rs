//! A load behind a gap: as compliance, with a dead zone of that total width.

use plant::effects::Shaft;

use super::{Effect, LOAD_SIDE, PLAIN, Parameter, Size, Widening, free, rough, shown, sized};

/// Up to a quarter of the sample rate: four samples a period show it.
const RESONANCE: Parameter = sized(Size::Rate, 1e-4, 0.25, 2.5e-3);

/// Gaps that are tried, in travels.
const GAPS: [f64; 6] = [2.5e-4, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3];

/// Its own resonance over that of a shaft without a gap in its place.
const SOFTENED: [f64; 3] = [1.0, 1.1, 1.25];

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "backlash",
    sentence: "Part of the inertia hangs behind a gap: gear, key, spline or coupling with play.",
    parameters: &[rough(sized(Size::Travel, 0.0, 0.1, 1e-3)), RESONANCE, free(1e-3, 1.0, 0.02), free(1e-2, 5.0, 0.1)],
    starts: |_, e| {
        let mut all = Vec::new();
        for gap in GAPS {
            for hz in [25.0, 60.0, 140.0] {
                all.extend([0.15, 0.4, 1.0].map(|ratio| vec![gap * e.travel.max(1e-6), hz, 0.05, ratio]));
            }
        }
        all
    },
    put: |p, v| p.model.shaft = Some(Shaft { gap: v[0], resonance_hz: v[1], damping_ratio: v[2], inertia_ratio: v[3] }),
    measured_by: Some(LOAD_SIDE),
    remembers: true,
    // A shaft that is followed to its resonance without a gap leaves little but the gap to find, and how much that had softened it.
    widens: Some(Widening {
        narrower: &super::compliance::EFFECT,
        wider: |shaft, e| {
            let of = |gap: f64| SOFTENED.map(|by| vec![gap * e.travel.max(1e-6), by * shaft[0], shaft[1], shaft[2]]);
            GAPS.into_iter().flat_map(of).collect()
        },
        within: |gap_and_shaft| gap_and_shaft[1..].to_vec(),
    }),
    example: shown(|f| vec![0.004 * f, 60.0, 0.05, 0.4 * f]),
    ..PLAIN
};
