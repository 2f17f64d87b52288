#![allow(clippy::unwrap_used, clippy::panic)]
use super::formula;
use crate::decide::testing::{machine, recording};
use crate::effects::{Harmonic, Physics};
use crate::read::{AxisKind, Recording};
use crate::report::Formula;
use crate::screen::{Motion, Problem, Search};

/// The formula for a machine with something the nominal one lacks, from two recordings and one held out; no effect of the
/// vocabulary was tried. What the recorded torque lacks is put in by `missing`, of position and sign of the speed.
fn found(change: impl Fn(&mut Physics), missing: impl Fn(&mut Recording)) -> Option<Formula> {
    let machine = machine();
    let nominal = Physics::nominal(&machine);
    let mut truth = nominal.clone();
    change(&mut truth);
    let motions = (1..=3).map(|seed| {
        let mut recorded = recording(&truth, 0.02, 6.0, seed);
        missing(&mut recorded);
        Motion::new(&recorded, &nominal, machine.axis.resolution)
    });
    let problem = Problem::new(motions.collect(), 2, nominal);
    let outcome = Search::new(&problem, &[], false).run(&[]);
    formula(&problem, &outcome, AxisKind::Rotary)
}

/// Takes a torque out of the recorded commands, so that the machine seems to have it. The drive's delay of ten samples is
/// allowed for.
fn seems_to_have(recorded: &mut Recording, torque: impl Fn(f64, f64) -> f64) {
    let position = recorded.position.clone();
    for row in 0..position.len() - 12 {
        let speed = position[row + 11] - position[row + 9];
        recorded.effort_cmd[row] -= torque(position[row + 10], speed);
    }
}

#[test]
fn friction_that_depends_on_position_is_said_to_be_that() {
    let friction = |q: f64, speed: f64| -0.3 * speed.signum() * (3.0 * q + 0.4).sin();
    let found = found(|_| (), |recorded| seems_to_have(recorded, friction)).unwrap();
    assert_eq!(found.terms[0].text, "sign(w) \u{b7} sin(3 x + phase)", "{}", found.text);
    let amplitude = &found.terms[0].parameters[0];
    assert!((amplitude.value - 0.3).abs() < 0.02 && amplitude.unit == "N m", "{}", found.text);
    assert!(found.heldout_gain > 0.4 && found.excess_explained > 0.9, "{found:?}");
}

#[test]
fn a_spring_that_stiffens_is_a_cube_of_the_position() {
    let spring = |q: f64, _: f64| -1.5 * q.powi(3);
    let found = found(|_| (), |recorded| seems_to_have(recorded, spring)).unwrap();
    assert_eq!(found.terms[0].text, "x\u{b3}", "{}", found.text);
    let stiffness = &found.terms[0].parameters[0];
    assert!(stiffness.low < -1.5 && -1.5 < stiffness.high && stiffness.unit == "N m/rad\u{b3}", "{found:?}");
}

#[test]
fn cogging_of_a_simulated_machine_is_a_wave_with_its_phase() {
    let teeth = Harmonic { order: 7.0, sine: 0.2, cosine: 0.2 };
    let found = found(|machine| machine.cogging.push(teeth), |_| ()).unwrap();
    assert_eq!((found.terms.len(), found.terms[0].text.as_str()), (1, "sin(7 x + phase)"), "{}", found.text);
    let [amplitude, phase] = found.terms[0].parameters.as_slice() else { panic!("{found:?}") };
    assert!((amplitude.value - 0.2 * 2.0_f64.sqrt()).abs() < 0.01, "{found:?}");
    assert!((phase.value - std::f64::consts::FRAC_PI_4).abs() < 0.05 && phase.low < phase.high, "{found:?}");
}

#[test]
fn what_is_clean_has_no_formula() {
    assert_eq!(found(|_| (), |_| ()), None);
}
