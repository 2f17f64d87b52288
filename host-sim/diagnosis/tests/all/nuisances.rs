//! What is no effect of the vocabulary competes with those that are: an effect is not named where a nuisance explains as much.

use crate::common::{Making, PLAIN, STEP_RAD, three};
use diagnosis::effects::{Effect, VOCABULARY};
use diagnosis::physics::Physics;
use diagnosis::pipeline::{Conclusion, diagnose};
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use diagnosis::verdict::Verdict;
use plant::Model;

fn torque(t_s: f64, phase: f64) -> f64 {
    2.5 * (3.1 * t_s + phase).sin()
        + 1.5 * (11.0 * t_s + 2.0 * phase).sin()
        + if (t_s * 1.3) % 1.0 < 0.2 { 0.0 } else { 0.4 }
}

/// Moves a rotor of a seventh of the inertia as far as the others move the whole.
fn slow(t_s: f64, phase: f64) -> f64 {
    0.7 * (3.1 * t_s + phase).sin() + 0.3 * (11.0 * t_s + 2.0 * phase).sin()
}

/// Time over which the drive takes the mean of its commands, s.
const BLUR_S: f64 = 0.016;

fn blurred(t_s: f64, phase: f64) -> f64 {
    let many = 16;
    let before = |index: i32| torque(t_s - BLUR_S * (f64::from(index) + 0.5) / f64::from(many), phase);
    (0..many).map(before).sum::<f64>() / f64::from(many)
}

fn machine() -> Model {
    Model { coulomb: 0.5, torque_delay_s: 0.002, ..Model::new(0.05) }
}

fn recorded(actual: &Model, acting: fn(f64, f64) -> f64) -> Vec<Recorded> {
    let making = Making { torque: acting, seconds: 4.0, noise_nm: 0.02, step_rad: STEP_RAD, ..PLAIN };
    three(actual, making)
}

fn concluded(recordings: Vec<Recorded>, without: &[&str]) -> Conclusion {
    let vocabulary: Vec<&'static Effect> =
        VOCABULARY.iter().copied().filter(|effect| !without.contains(&effect.id)).collect();
    let problem = Problem::new(Physics::new(machine()), recordings, 2, STEP_RAD, false);
    diagnose(&problem, &vocabulary).unwrap()
}

fn nuisances(conclusion: &Conclusion) -> Vec<&'static str> {
    conclusion.effects.iter().flat_map(|effect| &effect.nuisances).map(|nuisance| nuisance.id).collect()
}

#[test]
fn a_mean_of_commands_is_neither_called_a_delay_nor_a_lag() {
    let mut recordings = recorded(&machine(), blurred);
    for (seed, recording) in (1..=3).zip(&mut recordings) {
        for (command, t_s) in recording.commands.iter_mut().zip(&recording.t_s) {
            command.torque = torque(*t_s, f64::from(seed));
        }
    }
    let found = concluded(recordings, &[]);
    println!("{:?} {:?}", found.verdict, found.effects);
    assert!(!matches!(found.verdict, Verdict::Named | Verdict::None), "{:?}", found.effects);
    assert!(found.verdict == Verdict::Unknown || nuisances(&found).contains(&"blurred_command"), "{:?}", found.effects);
}

#[test]
fn a_wrong_inertia_that_may_not_be_named_is_no_wrong_gain() {
    let found = concluded(recorded(&Model { inertia: 0.06, ..machine() }, torque), &["inertia"]);
    println!("{:?} {:?}", found.verdict, found.effects);
    assert_eq!(found.verdict, Verdict::Ambiguous, "{:?}", found.effects);
    assert!(nuisances(&found).contains(&"scale_of_torques"), "{:?}", found.effects);
}

/// A machine file with a unit mistaken, or a motor that was thought to carry its load.
#[test]
fn an_inertia_of_a_seventh_is_named_and_no_resonance() {
    let found = concluded(recorded(&Model { inertia: 0.05 / 7.0, ..machine() }, slow), &[]);
    println!("{:?} {:?}", found.verdict, found.effects);
    assert_eq!(found.effects[0].effect.id, "inertia", "{:?}", found.effects);
    let value = found.effects[0].intervals[0];
    assert!((value.value * 7.0 / 0.05 - 1.0).abs() < 0.05, "{value:?}");
}

#[test]
fn a_torque_over_position_that_is_no_effect_is_not_named_as_one() {
    let wave = plant::effects::Harmonic { amplitude: 0.3, order: 0.6, phase_rad: 1.0 };
    let actual = Model { cogging: vec![wave], ..machine() };
    let found = concluded(recorded(&actual, torque), &["cogging"]);
    println!("{:?} {:?}", found.verdict, found.effects);
    assert_ne!(found.verdict, Verdict::Named, "{:?}", found.effects);
}
