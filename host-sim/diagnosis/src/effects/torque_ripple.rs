//! The drive's gain over position: 1 + amplitude sin(order th + phase); one entry for each order.

use super::{
    Columns, Effect, LowestOrder, PLAIN, amplitude_order_phase, commanded, fixed, free, harmonic, order_sine_cosine,
    shown,
};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "torque_ripple",
    sentence: "The drive's torque pulses over position in proportion to itself: currents, windings or magnets that are no perfect sines.",
    // From 1 on the drive would pull the other way.
    parameters: &[fixed(), free(-0.6, 0.6, 0.02), free(-0.6, 0.6, 0.02)],
    // Of a measured torque it would only say that less was measured.
    applies: commanded,
    starts: |_, e| e.ripple_orders.iter().map(|&order| vec![order, 0.0, 0.0]).collect(),
    put: |p, v| p.model.torque_ripple.push(harmonic(v)),
    report: amplitude_order_phase,
    fitted: order_sine_cosine,
    columns: Columns::Each,
    // Less than once in the travel is a gain of the drive.
    lowest_order: Some(LowestOrder { of_revolution: 1.0, of_travel: 1.0 }),
    repeats: true,
    looked_at: |e| e.looked_at[0],
    example: shown(|f| vec![14.0, 0.06 * f, 0.05 * f]),
    ..PLAIN
};

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use crate::effects::Excitation;

    #[test]
    fn a_ripple_comes_back_within_the_travel() {
        let lowest = |travel: f64, linear: bool| {
            let excitation = Excitation { travel, linear, ..Excitation::default() };
            excitation.lowest_order(&super::EFFECT)
        };
        assert_eq!(lowest(10.0 * TAU, false), Some(1.0));
        assert_eq!(lowest(TAU / 4.0, false), Some(4.0));
        assert_eq!(lowest(0.2, true), Some(TAU / 0.2));
    }
}
