//! Dry friction as a bristle (Dahl): dF/dx = k (1 - F/c sign(w)).

use super::{Effect, PLAIN, Size, shown, sized};

/// Steps from one start to the next: the likelihood over the stiffness is wider than its factor.
const FINER: f64 = 3.0;
/// Least way that friction gives by, in steps of the sensor.
const LEAST_GIVEN: f64 = 0.25;
/// Softest bristle, in torques over the travel.
const SOFTEST: f64 = 1.0;

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "presliding",
    sentence: "Dry friction gives like a spring before it slides: asperities or balls that roll elastically.",
    parameters: &[sized(Size::Stiffness, SOFTEST, 1e7, 10.0)],
    applies: |p, _| p.model.coulomb > 0.0,
    // It gives by anything from a part of the sensor's step, which many reversals show, to a part of the travel.
    starts: |p, e| {
        let least = LEAST_GIVEN * Size::Step.of(p, e);
        let given = std::iter::successors(Some(Size::Travel.of(p, e) / FINER), |given| Some(given / FINER));
        let stiffnesses = given.take_while(|given| *given >= least).map(|given| p.model.coulomb / given);
        stiffnesses.filter(|stiffness| *stiffness >= SOFTEST * Size::Stiffness.of(p, e)).map(|k| vec![k]).collect()
    },
    put: |p, v| p.model.presliding_stiffness = Some(v[0]),
    neutral: |_| f64::INFINITY,
    remembers: true,
    example: shown(|f| vec![400.0 / f]),
    ..PLAIN
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Excitation;
    use crate::physics::Physics;
    use plant::Model;

    #[test]
    fn starts_go_along_with_the_unit_of_the_axis() {
        let physics = Physics::new(Model { coulomb: 2.0, ..Model::new(0.1) });
        let starts = |step, travel| {
            let excitation = Excitation { step, travel, torque_rms: 3.0, ..Excitation::default() };
            (EFFECT.starts)(&physics, &excitation)
        };
        let (rad, mm) = (starts(1e-4, 1.0), starts(1e-7, 1e-3));
        assert_eq!((rad.len(), mm.len()), (9, 9));
        for (rad, mm) in rad.iter().zip(&mm) {
            assert!((mm[0] / rad[0] - 1e3).abs() < 1e-6, "{rad:?} {mm:?}");
        }
        // The stiffest gives by a part of a step at the level, and the softest by a part of the travel.
        assert!(rad.iter().all(|k| k[0] <= 2.0 / 0.25e-4 && k[0] >= 3.0));
    }
}
