//! Dry friction: -c sign(w).

use super::{Columns, Effect, PLAIN, Size, gives_way, shown, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "coulomb_friction",
    sentence: "Dry friction is not at its nominal level: bearings, seals, preload, or a zero-field drag counted wrongly.",
    parameters: &[sized(Size::Torque, 0.0, 1e3, 0.05)],
    starts: |p, _| vec![vec![p.model.coulomb]],
    put: |p, v| p.model.coulomb = v[0],
    explains: gives_way,
    neutral: |p| p.model.coulomb,
    columns: Columns::Each,
    example: shown(|f| vec![0.763 + 0.19 * f]),
    ..PLAIN
};

#[cfg(test)]
mod tests {
    use plant::Model;
    use plant::effects::{Gravity, Stribeck};

    use super::EFFECT;
    use crate::effects::Excitation;
    use crate::physics::Physics;

    #[test]
    fn a_level_that_nothing_overcomes_explains_nothing() {
        let excitation = Excitation { torque_peak: 3.5, travel: 0.5, ..Excitation::default() };
        let bare = || Model { torque_offset: 0.0, ..Model::paper() };
        let weight = |amplitude| Some(Gravity { amplitude, phase_rad: 0.0 });
        let rising = Some(Stribeck { excess: 14.0, velocity: 0.001 });
        for (model, level, explains) in [
            (bare(), 3.4, true),
            (bare(), 4.5, false),
            (Model { gravity: weight(8.0), ..bare() }, 4.5, true),
            (Model { gravity: weight(8.0), ..bare() }, 12.0, false),
            (Model { torque_offset: -2.0, ..bare() }, 4.5, true),
            (Model { spring_stiffness: 4.0, ..bare() }, 4.5, true),
            (Model { stribeck: rising, ..bare() }, 0.7, false),
        ] {
            let mut physics = Physics::new(model);
            (EFFECT.put)(&mut physics, &[level]);
            assert_eq!((EFFECT.explains)(&physics, &excitation), explains, "level {level} of {:?}", physics.model);
        }
    }
}
