//! What the tool must say of recordings whose truth is known.

use diagnosis::physics::{Physics, Push};
use lab::report::Verdict;
use plant::effects::Pulse;

use crate::cases::{answer, recordings};

#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation; the tests in release run it")]
fn nothing_is_named_where_nothing_is_missing() {
    let answer = answer(&recordings(&|_| (), 11, 0.05), "");
    assert_eq!(answer.verdict, Verdict::None, "{answer:?}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation; the tests in release run it")]
fn dry_friction_is_named_alone_and_its_interval_holds_the_truth() {
    let answer = answer(&recordings(&|physics| physics.model.coulomb = 0.95, 12, 0.05), "");
    assert_eq!(answer.verdict, Verdict::Named, "{answer:?}");
    assert_eq!(answer.effects.len(), 1, "{answer:?}");
    let effect = &answer.effects[0];
    assert_eq!(effect.id, "coulomb_friction");
    let level = &effect.parameters[0];
    // No narrower than a fiftieth of a typical change, 0.6 % of this level to either side.
    assert!(level.low < 0.95 && 0.95 < level.high && level.high - level.low < 0.015, "{level:?}");
    assert!(answer.fit.heldout_after_rms < answer.fit.heldout_before_rms);
}

#[test]
#[ignore = "missed: partial, a compliance certainly adds to the likelihood beside the push, and nothing to the motion"]
fn a_push_against_a_rotor_at_rest_is_named_with_its_time_and_size() {
    let truth = [3.1, 0.12, 2.0];
    let pulse = Pulse { start_s: truth[0], duration_s: truth[1], amplitude: truth[2] };
    let push = Push { recording: 0, pulse };
    let answer = answer(&recordings(&|physics| physics.pushes.push(push), 13, 0.05), "");
    assert_eq!(answer.verdict, Verdict::Named, "{answer:?}");
    let [effect] = answer.effects.as_slice() else { panic!("{:?}", answer.effects) };
    assert_eq!((effect.id.as_str(), effect.recording.as_deref()), ("disturbance_pulse", Some("a.csv")));
    for (parameter, truth) in effect.parameters.iter().zip(truth) {
        assert!(parameter.low <= truth && truth <= parameter.high, "{parameter:?}, is {truth}");
    }
}

/// Of the machines that one scale makes alike, this one has two changes; with another scale of the drive it has three.
#[test]
#[ignore = "missed: ambiguous, coulomb_friction, er_strength and torque_gain, with inertia for the gain"]
fn a_strength_and_an_inertia_are_no_scale_of_the_drive() {
    let change = |physics: &mut Physics| {
        physics.model.inertia = 0.0814;
        physics.model.er.as_mut().unwrap().scale = 1.184;
    };
    let answer = answer(&recordings(&change, 15, 0.015), "");
    let mut found: Vec<&str> = answer.effects.iter().map(|effect| effect.id.as_str()).collect();
    found.sort_unstable();
    assert_eq!((answer.verdict, found.as_slice()), (Verdict::Named, &["er_strength", "inertia"][..]), "{answer:?}");
}
