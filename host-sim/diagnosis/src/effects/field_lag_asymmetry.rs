//! First-order lag of the field that differs for rising and falling field.

use super::{Effect, PLAIN, free, shown_by, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "field_lag_asymmetry",
    sentence: "The field falls at another pace than it rises: an amplifier that sources but hardly sinks current, or a fluid that relaxes slowly.",
    parameters: &[free(0.0, 0.2, 1e-3), free(0.0, 0.2, 1e-3)],
    applies: with_field,
    starts: |p, _| {
        let d = p.field().map_or(0.0, |field| field.rise_s);
        let g = [0.0, d, d + 3e-3, d + 10e-3, d + 30e-3];
        let mut all = Vec::new();
        for rise in g {
            for fall in g {
                if rise != fall {
                    all.push(vec![rise, fall]);
                }
            }
        }
        all
    },
    put: |p, v| {
        p.with_field(|field| (field.rise_s, field.fall_s) = (v[0], v[1]));
    },
    leading: &[1],
    neutral: |p| p.field().map_or(0.0, |field| field.fall_s),
    example: shown_by(1, |f| vec![0.003, 0.003 + 0.009 * f]),
    ..PLAIN
};
