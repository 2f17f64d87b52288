//! The paper's own experiment asked for its delay: single steps, a fluid whose field waits 2 ms and lags 3 ms.

use std::path::Path;

use crate::servo::{PERIOD_S, field, paper, setup};
use analysis::simulate::{Reference, Setup, record, run};
use diagnosis::effects::VOCABULARY;
use er_servo::Config;
use er_servo::experiment::{Experiment, Shape};
use lab::conclude;
use lab::delays::{Answer, Candidate, Request, Verdict, answer, figure};
use lab::read::{Machine, Recording};
use lab::report;
use plant::{Er, FluidResponse};

/// Noise of a recording that tells little: three steps of the sensor, and ten times the torque noise of the other tests.
const POOR_SENSOR_RAD: f64 = 4e-5;
const POOR_TORQUE_NM: f64 = 0.1;

/// The paper's servo, its fluid without delay.
fn machine() -> Machine {
    Machine::from_bytes(Path::new("machine.toml"), include_bytes!("../../src/cli/demo/machine.toml")).unwrap()
}

/// Two seconds after one step under a fluid.
fn step(response: FluidResponse, degrees: f32, seed: u64) -> Recording {
    let experiment = Experiment { shape: Shape::Step { amplitude_rad: degrees.to_radians() }, duration_s: 2.0 };
    recorded(response, experiment, (0.0, 0.01), seed)
}

/// An experiment under a fluid, with noise of the sensor, rad, and of the torque, N m.
fn recorded(response: FluidResponse, experiment: Experiment, noise: (f64, f64), seed: u64) -> Recording {
    let (sensor_noise_rad, torque_noise_nm) = noise;
    let setup = Setup { sensor_noise_rad, torque_noise_nm, seed, ..setup(paper(response), Config::default()) };
    let rows = run(&setup, Reference::Experiment(experiment).positions(PERIOD_S).unwrap()).unwrap();
    record(&format!("experiment{seed}.csv"), &rows)
}

/// Steps of 30, 20 and 10 degrees, and one of 25 that only judges.
fn steps(response: FluidResponse) -> (Vec<Recording>, Vec<Recording>) {
    let fitted = [(30.0, 1), (20.0, 2), (10.0, 3)].map(|(degrees, seed)| step(response, degrees, seed));
    (fitted.to_vec(), vec![step(response, 25.0, 4)])
}

fn asked(response: FluidResponse) -> Answer {
    let (recordings, holdout) = steps(response);
    let found = answer(&Request { machine: &machine(), recordings: &recordings, holdout: &holdout }).unwrap();
    println!("{found}");
    found
}

fn left(answer: &Answer) -> Vec<&'static str> {
    answer.candidates.iter().filter(|one| one.needed).map(|one| one.name).collect()
}

#[test]
fn the_papers_steps_leave_delays_of_the_field_and_an_experiment_that_separates_them() {
    let answer = asked(field(0.002, 0.003));
    let left = left(&answer);
    assert!(!left.is_empty() && left.iter().all(|name| name.starts_with("E ")), "{left:?}");
    let both = answer.candidates.iter().find(|one| one.name == "E dead and lag").unwrap();
    assert!(both.in_set, "{both:?}");
    match answer.verdict {
        Verdict::Named => {
            for (value, truth_s) in both.values.iter().zip([0.002, 0.003]) {
                assert!(value.low_s <= truth_s && truth_s <= value.high_s, "{value:?}");
            }
        }
        Verdict::Ambiguous => assert!(answer.plans[0].separates, "{:?}", answer.plans),
    }
    let svg = figure(&answer).to_svg().unwrap();
    assert!(svg.contains("log-likelihood below the best") && svg.contains("time over all recordings (s)"));
}

#[test]
fn one_delay_is_told_from_two() {
    let answer = asked(field(0.005, 0.0));
    assert!(left(&answer).contains(&"E dead"), "{:?}", left(&answer));
    assert!(!left(&answer).contains(&"E dead and lag"), "{:?}", left(&answer));
}

/// A viscosity that waits, as a fluid can.
fn bounded_q_dead(dead_time_s: f64) -> FluidResponse {
    FluidResponse::ViscosityDeadTime { dead_time_s, torque_limit: Er::largest_torque(0.0704, 0.470) }
}

#[test]
fn a_late_viscosity_is_not_taken_for_a_late_field() {
    let answer = asked(bounded_q_dead(0.005));
    let truth = answer.candidates.iter().find(|one| one.name == "Q dead").unwrap();
    assert!(truth.in_set && truth.needed, "{truth:?}");
    let [value] = &truth.values[..] else { panic!("{truth:?}") };
    assert!(value.low_s <= 0.005 && 0.005 <= value.high_s, "{value:?}");
    assert!(left(&answer).iter().all(|name| name.starts_with("Q ")), "{:?}", left(&answer));
}

/// The fluid of a candidate at its fitted values.
fn response_of(candidate: &Candidate) -> FluidResponse {
    let torque_limit = Er::largest_torque(0.0704, 0.470);
    let values: Vec<f64> = candidate.values.iter().map(|value| value.value_s).collect();
    match (candidate.name, &values[..]) {
        ("none", []) => field(0.0, 0.0),
        ("Q dead", [dead_time_s]) => FluidResponse::ViscosityDeadTime { dead_time_s: *dead_time_s, torque_limit },
        ("Q lag", [lag_s]) => FluidResponse::ViscosityLag { lag_s: *lag_s, torque_limit },
        ("E dead", [dead_time_s]) => field(*dead_time_s, 0.0),
        ("E lag", [lag_s]) => field(0.0, *lag_s),
        ("E dead and lag", [dead_time_s, lag_s]) => field(*dead_time_s, *lag_s),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_proposed_experiment_leaves_whichever_model_is_true() {
    // One small step, cut short, under noise: two models are left.
    let noise = (POOR_SENSOR_RAD, POOR_TORQUE_NM);
    let shape = Shape::Step { amplitude_rad: 5.0_f32.to_radians() };
    let poor = recorded(field(0.002, 0.003), Experiment { shape, duration_s: 0.3 }, noise, 5);
    let ask = |recording: Recording| {
        let found = answer(&Request { machine: &machine(), recordings: &[recording], holdout: &[] }).unwrap();
        println!("{found}");
        found
    };
    let first = ask(poor);
    assert_eq!(first.verdict, Verdict::Ambiguous);
    let both = first.candidates.iter().find(|one| one.name == "E dead and lag").unwrap();
    assert!(both.in_set, "{both:?}");
    let plan = &first.plans[0];
    assert!(plan.separates, "{plan:?}");
    for (seed, truth) in (11..).zip(first.candidates.iter().filter(|one| one.needed)) {
        // Another draw of the noise than the one the experiment was weighed with.
        let second = ask(recorded(response_of(truth), plan.experiment, noise, seed));
        assert_eq!(left(&second), [truth.name], "{}", plan.name);
    }
}

/// What `diagnose` says of the paper's steps under a fluid: named, with these delays, s, each in its interval and to a share.
fn named(response: FluidResponse, truth: &[(&str, f64)], share: f64) {
    let machine = machine();
    let (recordings, holdout) = steps(response);
    let request =
        conclude::Request { machine: &machine, recordings: &recordings, holdout: &holdout, vocabulary: &VOCABULARY };
    let found = conclude::diagnose(&request).unwrap().answer;
    let mut ids: Vec<&str> = found.effects.iter().map(|effect| effect.id.as_str()).collect();
    println!("{:?} {ids:?} {:?}", found.verdict, found.effects);
    assert_eq!(found.verdict, report::Verdict::Named, "{ids:?}");
    ids.sort_unstable();
    assert_eq!(ids, truth.iter().map(|(id, _)| *id).collect::<Vec<_>>());
    for (id, delay_s) in truth {
        let effect = found.effects.iter().find(|effect| effect.id == *id).unwrap();
        let [value] = &effect.parameters[..] else { panic!("{effect:?}") };
        assert!(value.low <= *delay_s && *delay_s <= value.high, "{id}: {value:?}");
        assert!((value.value / delay_s - 1.0).abs() < share, "{id}: {value:?}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn the_papers_steps_are_named_with_both_delays_of_the_field() {
    named(field(0.002, 0.003), &[("field_dead_time", 0.002), ("field_lag", 0.003)], 0.01);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_viscosity_that_waits_is_named() {
    named(bounded_q_dead(0.005), &[("viscosity_dead_time", 0.005)], 0.002);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_viscosity_that_lags_is_named() {
    let torque_limit = Er::largest_torque(0.0704, 0.470);
    named(FluidResponse::ViscosityLag { lag_s: 0.005, torque_limit }, &[("viscosity_lag", 0.005)], 0.002);
}
