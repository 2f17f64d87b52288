//! Torque over position: amplitude sin(order th + phase); one entry for each order.

use super::{
    Columns, Effect, HOLDING, LowestOrder, PLAIN, Size, amplitude_order_phase, fixed, harmonic, order_sine_cosine,
    shown, sized,
};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "cogging",
    sentence: "A torque that repeats over position: cogging of magnets against teeth, commutation error, or a ripple of the gear.",
    parameters: &[fixed(), sized(Size::Torque, -1e2, 1e2, 0.05), sized(Size::Torque, -1e2, 1e2, 0.05)],
    starts: |_, e| e.orders.iter().map(|&order| vec![order, 0.0, 0.0]).collect(),
    put: |p, v| p.model.cogging.push(harmonic(v)),
    report: amplitude_order_phase,
    fitted: order_sine_cosine,
    columns: Columns::Each,
    // Once in a revolution is gravity; less than half a period in the travel is a slope, as an offset, a spring and a weight make.
    lowest_order: Some(LowestOrder { of_revolution: 2.0, of_travel: 0.5 }),
    repeats: true,
    looked_at: |e| e.looked_at[0],
    measured_by: Some(HOLDING),
    example: shown(|f| vec![14.0, 0.16 * f, 0.25 * f]),
    ..PLAIN
};

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use crate::effects::Excitation;

    #[test]
    fn half_a_period_is_in_the_travel() {
        let lowest = |travel: f64| {
            let excitation = Excitation { travel, ..Excitation::default() };
            excitation.lowest_order(&super::EFFECT)
        };
        assert_eq!(lowest(TAU), Some(2.0));
        assert_eq!(lowest(TAU / 16.0), Some(8.0));
    }
}
