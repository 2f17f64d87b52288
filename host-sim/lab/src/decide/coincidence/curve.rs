//! A fluid whose torque bends over the field otherwise than its law.
//!
//! The ER torque a E^2 + b E under a gain of the field or a scale of its own keeps the family of its curve: gain and scale
//! change a and b in a fixed proportion. Where a must change by itself beside them, neither is the cause. The two differ in
//! that proportion only, so that one of them is a claim about the bend too.

use crate::effects::{Effect, as_fitted, find, free, with_field};
use crate::screen::{MAX_P, MIN_T, Outcome, Problem, Refitter, fall_t};

/// Effects that claim to know what became of the curve.
const CLAIMS: [&str; 2] = ["field_gain", "er_strength"];

/// No law of a fluid is known better than to this share of its coefficients.
const KNOWN: f64 = 0.1;

/// The coefficient of the squared field by itself; a probe, no effect of the vocabulary.
static BEND: Effect = Effect {
    id: "bend",
    sentence: "The fluid's torque grows otherwise with the square of the field.",
    parameters: &[free(0.0, 10.0, 0.1)],
    applies: with_field,
    starts: |_, _| vec![vec![1.0]],
    put: |p, v| {
        if let Some(damper) = &mut p.damper {
            damper.a *= v[0];
        }
    },
    report: as_fitted,
};

/// In words, which effect of the best model scales a curve that is another one.
pub(in crate::decide) fn bent(problem: &Problem, outcome: &Outcome) -> Option<String> {
    let claim = outcome.fit.active.iter().find(|entry| CLAIMS.contains(&entry.effect.id))?;
    let refitter = Refitter::new(problem, outcome);
    let base = refitter.fit(&outcome.fit.active);
    let probe = refitter.entry(&BEND, vec![1.0]);
    let with = refitter.fit(&[base.active.as_slice(), &[probe]].concat());
    let factor = with.active.last()?.values[0];
    let (p_value, t) = (refitter.p_value(&base, &with), fall_t(&base.heldout, &with.heldout));
    ((factor - 1.0).abs() > KNOWN && p_value < MAX_P && t >= MIN_T).then(|| {
        format!(
            "{}: the torque over the field is bent otherwise than it makes it, as if the coefficient of the squared field were \
             {factor:.3} times its own: not its cause",
            claim.effect.id
        )
    })
}

/// In words, that the effect which scales the curve is not told from the other one, which the `vocabulary` does not have. One
/// that may be named is among the equivalents.
pub(in crate::decide) fn undecided(
    problem: &Problem,
    outcome: &Outcome,
    vocabulary: &[&'static Effect],
) -> Option<String> {
    let (claims, beside): (Vec<_>, Vec<_>) =
        outcome.fit.active.iter().cloned().partition(|entry| CLAIMS.contains(&entry.effect.id));
    let claim = claims.first()?;
    let other = CLAIMS.into_iter().find(|id| *id != claim.effect.id).and_then(find)?;
    if vocabulary.iter().any(|effect| effect.id == other.id) {
        return None;
    }
    let refitter = Refitter::new(problem, outcome);
    let claimed = refitter.fit(&outcome.fit.active);
    let start = refitter.starts(&beside, other).into_iter().next()?;
    let swapped = refitter.fit(&[beside.as_slice(), &[start]].concat());
    (fall_t(&swapped.heldout, &claimed.heldout) < MIN_T).then(|| {
        format!(
            "{}: a factor on the whole of the fluid's torque and one on its field are not told apart by these recordings",
            claim.effect.id
        )
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::tests::nominal;
    use super::*;
    use crate::decide::testing::multisine;
    use crate::effects::Physics;
    use crate::screen::{Motion, Search};

    #[test]
    fn a_strength_that_is_called_a_gain_bends_the_curve() {
        let mut weak = nominal();
        weak.damper.as_mut().unwrap().scale = 0.7;
        let recorded = multisine(&weak, 0.05, 8.0, 3);
        let problem = Problem::new(vec![Motion::new(&recorded, &nominal(), 1.3e-5)], 1, nominal());
        let called = |id: &str| {
            let outcome = Search::new(&problem, &[find(id).unwrap()], false).run(&[]);
            assert_eq!(outcome.fit.active.len(), 1, "{id}");
            bent(&problem, &outcome)
        };
        assert!(called("field_gain").unwrap().starts_with("field_gain: "));
        assert_eq!(called("er_strength"), None);
    }

    #[test]
    fn a_gain_alone_in_the_vocabulary_must_be_told_from_a_strength() {
        let (gain, strength) = (find("field_gain").unwrap(), find("er_strength").unwrap());
        let judged = |change: fn(&mut Physics), vocabulary: &[&'static Effect]| {
            let mut machine = nominal();
            change(&mut machine);
            let recorded = multisine(&machine, 0.05, 8.0, 3);
            let problem = Problem::new(vec![Motion::new(&recorded, &nominal(), 1.3e-5)], 1, nominal());
            let outcome = Search::new(&problem, &[gain], false).run(&[]);
            assert_eq!(outcome.fit.active.len(), 1);
            undecided(&problem, &outcome, vocabulary)
        };
        let weak: fn(&mut Physics) = |machine| machine.damper.as_mut().unwrap().scale = 0.8;
        let low: fn(&mut Physics) = |machine| machine.damper.as_mut().unwrap().gain = 0.8;
        assert!(judged(weak, &[gain]).unwrap().starts_with("field_gain: "));
        assert_eq!(judged(weak, &[gain, strength]), None);
        assert_eq!(judged(low, &[gain]), None);
    }
}
