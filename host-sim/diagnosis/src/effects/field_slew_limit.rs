//! The field changes at a limited rate: |dE_d/dt| <= r.

use super::{Effect, PLAIN, free, with_field};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "field_slew_limit",
    sentence: "The field changes at a limited rate: the current limit of the high-voltage amplifier into the damper's capacitance.",
    // Faster than the whole field in a tick, nothing is left of it in the samples.
    parameters: &[free(5.0, 7e3, 100.0)],
    applies: with_field,
    starts: |_, _| [2000.0, 1000.0, 500.0, 250.0, 120.0, 60.0, 30.0].iter().map(|&v| vec![v]).collect(),
    put: |p, v| {
        p.with_field(|field| field.slew_kv_mm_s = Some(v[0]));
    },
    neutral: |_| f64::INFINITY,
    ..PLAIN
};
