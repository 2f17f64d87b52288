//! The paper's own experiment asked for its delay: single steps, a fluid whose field waits 2 ms and lags 3 ms.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../../analysis/tests/common/mod.rs"]
mod common;

use std::path::Path;

use analysis::simulate::{Reference, Setup, record, run};
use common::{PERIOD_S, field, paper, q_dead, setup};
use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use diagnosis::pipeline::diagnose;
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use er_servo::Config;
use er_servo::experiment::{Experiment, Shape};
use lab::delays::{Answer, Request, Verdict, answer, figure};
use lab::read::{Machine, Recording};
use plant::{Er, FluidResponse};

/// The paper's servo, its fluid without delay.
fn machine() -> Machine {
    Machine::from_bytes(Path::new("machine.toml"), include_bytes!("../src/cli/demo/machine.toml")).unwrap()
}

/// Two seconds after one step under a fluid.
fn step(response: FluidResponse, degrees: f32, seed: u64) -> Recording {
    let experiment = Experiment { shape: Shape::Step { amplitude_rad: degrees.to_radians() }, duration_s: 2.0 };
    let setup = Setup { torque_noise_nm: 0.01, seed, ..setup(paper(response), Config::default()) };
    let rows = run(&setup, Reference::Experiment(experiment).positions(PERIOD_S).unwrap()).unwrap();
    record(&format!("step{degrees}.csv"), &rows)
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

#[test]
#[ignore = "missed: a viscosity 5 ms late under the fluid's own bound is ranked `none`"]
fn a_late_viscosity_is_not_taken_for_a_late_field() {
    let FluidResponse::ViscosityDeadTime { dead_time_s, .. } = q_dead(0.005) else { unreachable!() };
    let torque_limit = Er::largest_torque(0.0704, 0.470);
    let answer = asked(FluidResponse::ViscosityDeadTime { dead_time_s, torque_limit });
    assert!(left(&answer).iter().all(|name| name.starts_with("Q ")), "{:?}", left(&answer));
}

#[test]
#[ignore = "missed: `diagnose` answers partial, presliding, where `delays` ranks the field's dead time with its lag first"]
fn nothing_pushed_the_papers_steps() {
    let machine = machine();
    let (fitted, held) = steps(field(0.002, 0.003));
    let recorded: Vec<Recorded> = fitted.iter().chain(&held).map(Recorded::new).collect();
    let problem = Problem::new(Physics::nominal(&machine, &[]), recorded, fitted.len(), machine.axis.resolution, false);
    let found = diagnose(&problem, &VOCABULARY).unwrap();
    let ids: Vec<&str> = found.effects.iter().map(|named| named.effect.id).collect();
    println!("{:?} {ids:?}", found.verdict);
    assert!(ids.iter().all(|id| id.starts_with("field_")) && !ids.is_empty(), "{ids:?}");
}
