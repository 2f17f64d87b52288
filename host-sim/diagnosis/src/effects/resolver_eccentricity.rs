//! The measured position is th + amplitude sin(order th + phase).

use super::{
    Columns, Effect, LowestOrder, PLAIN, Size, amplitude_order_phase, fixed, harmonic, order_sine_cosine, shown, sized,
};

/// The entry of the vocabulary. A sensor that errs by more than a fiftieth of the travel is broken, and its slope is none of
/// a small correction any more.
pub static EFFECT: Effect = Effect {
    id: "resolver_eccentricity",
    sentence: "The position sensor errs with the angle: a resolver or encoder disc mounted off centre, or unequal windings.",
    parameters: &[fixed(), sized(Size::Travel, -0.02, 0.02, 1e-4), sized(Size::Travel, -0.02, 0.02, 1e-4)],
    // The error scales the acceleration, which no spectrum of the torque over the angle shows: the low orders are always
    // tried.
    starts: |_, e| {
        let low = (1..=8).map(f64::from).filter(|order| !e.linear && order * e.travel > 1.0);
        let others = e.orders.iter().copied().filter(|order| e.linear || *order > 8.0);
        low.chain(others).map(|order| vec![order, 0.0, 0.0]).collect()
    },
    put: |p, v| p.model.sensor.eccentricity.push(harmonic(v)),
    report: amplitude_order_phase,
    fitted: order_sine_cosine,
    columns: Columns::Each,
    // Its slope scales the motion, so that a part of a period shows.
    lowest_order: Some(LowestOrder { of_revolution: 1.0, of_travel: 0.0 }),
    repeats: true,
    looked_at: |e| e.looked_at[0],
    example: shown(|f| vec![4.0, 0.0018 * f, 0.001 * f]),
    ..PLAIN
};
