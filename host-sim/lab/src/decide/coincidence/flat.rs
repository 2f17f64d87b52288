//! A weight whose pull is not seen to change with the angle.
//!
//! Where an arm lies level in the middle of a short travel, its weight is nearly one torque. If a torque that is the same at
//! every position predicts as well, the angle is no part of what is missing.

use crate::effects::{Effect, Harmonic, Size, always, as_fitted, sized};
use crate::report::EffectAnswer;
use crate::screen::{MIN_T, Outcome, Problem, Refitter, fall_t};

/// A torque behind the drive's limit that is the same everywhere; a probe, no effect of the vocabulary.
static CONSTANT: Effect = Effect {
    id: "constant",
    sentence: "A torque that is the same at every position.",
    parameters: &[sized(Size::Torque, -1e2, 1e2, 0.05)],
    applies: always,
    starts: |_, e| vec![vec![0.05 * e.torque_rms]],
    put: |p, v| p.gravity = Some(Harmonic { order: 0.0, sine: 0.0, cosine: v[0] }),
    report: as_fitted,
};

/// In words, that the weight of the best model may as well be a constant torque. One that has equivalents in the answer is
/// open already.
pub(in crate::decide) fn flat(problem: &Problem, outcome: &Outcome, effects: &[EffectAnswer]) -> Option<String> {
    if effects.iter().any(|effect| effect.id == "gravity_load" && !effect.equivalent.is_empty()) {
        return None;
    }
    let (weight, beside): (Vec<_>, Vec<_>) =
        outcome.fit.active.iter().cloned().partition(|entry| entry.effect.id == "gravity_load");
    let weight = weight.first().filter(|_| problem.nominal.gravity.is_none())?;
    let refitter = Refitter::new(problem, outcome);
    let with_weight = refitter.fit(&outcome.fit.active);
    let probe = refitter.entry(&CONSTANT, vec![-weight.values[1]]);
    let without_angle = refitter.fit(&[beside.as_slice(), &[probe]].concat());
    (fall_t(&without_angle.heldout, &with_weight.heldout) < MIN_T).then(|| {
        format!(
            "gravity_load: a torque of {:.4} that is the same at every position predicts as well: the angle is not seen to \
             matter",
            without_angle.active.last().map_or(0.0, |entry| entry.values[0])
        )
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::tests::nominal;
    use super::*;
    use crate::decide::testing::multisine;
    use crate::effects::{Physics, find};
    use crate::screen::{Motion, Search};

    #[test]
    fn a_weight_that_stands_for_a_constant_torque_is_none() {
        let flat_for = |gravity: Harmonic| {
            let weighted = Physics { gravity: Some(gravity), ..nominal() };
            let recorded = multisine(&weighted, 0.05, 8.0, 3);
            let problem = Problem::new(vec![Motion::new(&recorded, &nominal(), 1.3e-5)], 1, nominal());
            let outcome = Search::new(&problem, &[find("gravity_load").unwrap()], false).run(&[]);
            assert_eq!(outcome.fit.active.len(), 1);
            flat(&problem, &outcome, &[])
        };
        assert!(flat_for(Harmonic { order: 0.0, sine: 0.0, cosine: 0.3 }).is_some());
        assert_eq!(flat_for(Harmonic { order: 1.0, sine: 0.3, cosine: 0.1 }), None);
    }
}
