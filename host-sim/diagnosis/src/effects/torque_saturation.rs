//! The drive's torque is limited either way.

use super::{Effect, PLAIN, Size, WEIGH, commanded, shown, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "torque_saturation",
    sentence: "The drive cannot give the torque that is commanded: current limit, or voltage limit at speed.",
    parameters: &[sized(Size::TorquePeak, 0.05, 10.0, 0.1)],
    applies: commanded,
    starts: |_, e| [0.95, 0.85, 0.7, 0.5, 0.3, 0.15, 0.08].iter().map(|&v| vec![v * e.torque_peak]).collect(),
    put: |p, v| p.model.torque_limit = Some(v[0]),
    // At or below the drag that it drives it lets nothing move.
    explains: |p| p.model.torque_limit.is_none_or(|limit| limit > p.model.coulomb),
    neutral: |p| p.model.torque_limit.unwrap_or(f64::INFINITY),
    measured_by: Some(WEIGH),
    example: shown(|f| vec![30.0 / (1.0 + 1.5 * f)]),
    ..PLAIN
};

#[cfg(test)]
mod tests {
    use plant::Model;

    use super::EFFECT;
    use crate::physics::Physics;

    #[test]
    fn a_limit_at_or_below_the_drag_explains_nothing() {
        for (coulomb, limit, explains) in [(0.0, 0.5, true), (0.7, 0.8, true), (0.7, 0.7, false), (0.7, 0.18, false)] {
            let mut physics = Physics::new(Model { coulomb, ..Model::paper() });
            (EFFECT.put)(&mut physics, &[limit]);
            assert_eq!((EFFECT.explains)(&physics), explains, "limit {limit}, drag {coulomb}");
        }
    }
}
