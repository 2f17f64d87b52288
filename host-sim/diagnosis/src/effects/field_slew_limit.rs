//! The field changes at a limited rate: |dE_d/dt| <= r.

use super::{Effect, PLAIN, Size, shown, sized, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "field_slew_limit",
    sentence: "The field changes at a limited rate: the current limit of the high-voltage amplifier into the damper's capacitance.",
    // Faster than the largest field in half a millisecond, nothing is left of it in the samples.
    parameters: &[sized(Size::Field, 0.5, 2e3, 30.0)],
    applies: with_field,
    // By the time to the largest field that was commanded, s.
    starts: |_, e| {
        [2e-3, 4e-3, 7e-3, 0.015, 0.03, 0.06, 0.12].iter().map(|&time_s| vec![e.field_peak / time_s]).collect()
    },
    put: |p, v| {
        p.with_field(|field| field.slew_kv_mm_s = Some(v[0]));
    },
    neutral: |_| f64::INFINITY,
    example: shown(|f| vec![200.0 / f]),
    ..PLAIN
};
