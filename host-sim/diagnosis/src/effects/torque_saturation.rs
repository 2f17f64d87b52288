//! The drive's torque is limited either way.

use super::{Effect, Excitation, PLAIN, Size, WEIGH, commanded, shown, sized};
use crate::physics::Physics;

/// Lowest limit that is looked at, of the largest command. Where it is likelier still below, what is commanded is not what moves the axis: of
/// two robots' joints, one that other joints moved and one whose gravity was missing, that was called a limit.
const LEAST: f64 = 0.05;

/// Whether a limit lets its commands through now and then, and is above the drag that it drives: else nothing would move.
fn explains(physics: &Physics, excitation: &Excitation) -> bool {
    let least = physics.model.coulomb.max(LEAST * excitation.torque_peak);
    physics.model.torque_limit.is_none_or(|limit| limit > least)
}

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "torque_saturation",
    sentence: "The drive cannot give the torque that is commanded: current limit, or voltage limit at speed.",
    parameters: &[sized(Size::TorquePeak, LEAST, 10.0, 0.1)],
    applies: commanded,
    starts: |_, e| [0.95, 0.85, 0.7, 0.5, 0.3, 0.15, 0.08].iter().map(|&v| vec![v * e.torque_peak]).collect(),
    put: |p, v| p.model.torque_limit = Some(v[0]),
    explains,
    neutral: |p| p.model.torque_limit.unwrap_or(f64::INFINITY),
    measured_by: Some(WEIGH),
    example: shown(|f| vec![30.0 / (1.0 + 1.5 * f)]),
    ..PLAIN
};

#[cfg(test)]
mod tests {
    use plant::Model;

    use super::EFFECT;
    use crate::effects::Excitation;
    use crate::physics::Physics;

    #[test]
    fn a_limit_at_or_below_the_drag_or_at_the_least_that_is_looked_at_explains_nothing() {
        let excitation = Excitation { torque_peak: 3.5, ..Excitation::default() };
        for (coulomb, limit, explains) in
            [(0.0, 0.5, true), (0.0, 0.05 * 3.5, false), (0.7, 0.8, true), (0.7, 0.7, false), (0.7, 0.18, false)]
        {
            let mut physics = Physics::new(Model { coulomb, ..Model::paper() });
            (EFFECT.put)(&mut physics, &[limit]);
            assert_eq!((EFFECT.explains)(&physics, &excitation), explains, "limit {limit}, drag {coulomb}");
        }
    }
}
