//! Whether what effects leave is the same noise in each recording.
#![allow(clippy::unwrap_used)]

mod common;

use common::{Making, PLAIN, STEP_RAD, recording, three};
use diagnosis::confidence_set::Step;
use diagnosis::effects::find;
use diagnosis::goodness::{Predictor, predictors};
use diagnosis::hypothesis::{Hypothesis, refit};
use diagnosis::physics::Physics;
use diagnosis::problem::Problem;
use diagnosis::search::first_noise;
use plant::Model;

const MAKING: Making = Making { torque, seconds: 3.0, noise_nm: 0.05, ..PLAIN };

fn torque(t_s: f64, phase: f64) -> f64 {
    2.5 * (5.1 * t_s + phase).sin() + 1.5 * (11.0 * t_s + 2.0 * phase).sin()
}

/// What tells the recordings' noise apart beside a friction that is there, where the last of three has this torque noise, N m.
fn of_last(noise_nm: f64) -> Option<Predictor> {
    let nominal = Model { coulomb: 0.5, torque_delay_s: 0.002, ..Model::new(0.05) };
    let slower = Model { viscous: 0.02, ..nominal.clone() };
    let mut recordings = three(&slower, MAKING);
    recordings[2] = recording(&slower, Making { noise_nm, ..MAKING }, 3);
    let problem = Problem::new(Physics::new(nominal), recordings, 2, STEP_RAD, false);
    let right = Hypothesis::default().with(find("viscous_friction").unwrap(), vec![0.02]);
    let step = Step::new(&problem, refit(&problem, &right, &first_noise(&problem), 3).unwrap()).unwrap();
    predictors(&problem, &step.assessed.refitted).into_iter().find(|one| one.channel == "recording")
}

#[test]
fn one_noise_is_no_news_and_one_that_is_four_times_as_large_is() {
    assert_eq!(of_last(MAKING.noise_nm), None);
    assert_eq!(of_last(1.2 * MAKING.noise_nm), None);
    let found = of_last(4.0 * MAKING.noise_nm).unwrap();
    println!("{found:?}");
    // Densities of 1, 1 and 16: the least is a sixth of their mean.
    assert!((found.share - 5.0 / 6.0).abs() < 0.05 && found.p_value < 1e-4, "{found:?}");
}
