//! Dry friction: -c sign(w).

use super::{Columns, Effect, Excitation, PLAIN, Size, shown, sized};
use crate::physics::Physics;

/// Whether it gives way to the largest torque of the drive and of a weight: under more nothing would ever move, and whatever else is missing
/// would show in nothing.
fn explains(physics: &Physics, excitation: &Excitation) -> bool {
    let weight = physics.model.gravity.as_ref().map_or(0.0, |gravity| gravity.amplitude);
    physics.model.coulomb < physics.model.torque_gain * excitation.torque_peak + weight
}

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "coulomb_friction",
    sentence: "Dry friction is not at its nominal level: bearings, seals, preload, or a zero-field drag counted wrongly.",
    parameters: &[sized(Size::Torque, 0.0, 1e3, 0.05)],
    starts: |p, _| vec![vec![p.model.coulomb]],
    put: |p, v| p.model.coulomb = v[0],
    explains,
    neutral: |p| p.model.coulomb,
    columns: Columns::Each,
    example: shown(|f| vec![0.763 + 0.19 * f]),
    ..PLAIN
};

#[cfg(test)]
mod tests {
    use plant::Model;
    use plant::effects::Gravity;

    use super::EFFECT;
    use crate::effects::Excitation;
    use crate::physics::Physics;

    #[test]
    fn a_level_that_nothing_overcomes_explains_nothing() {
        let excitation = Excitation { torque_peak: 3.5, ..Excitation::default() };
        for (amplitude, level, explains) in [(0.0, 3.4, true), (0.0, 4.5, false), (8.0, 4.5, true), (8.0, 12.0, false)]
        {
            let gravity = Some(Gravity { amplitude, phase_rad: 0.0 });
            let mut physics = Physics::new(Model { gravity, ..Model::paper() });
            (EFFECT.put)(&mut physics, &[level]);
            assert_eq!((EFFECT.explains)(&physics, &excitation), explains, "level {level}, weight {amplitude}");
        }
    }
}
