//! Whether what effects leave is the same noise in each recording.

use crate::common::{Making, PLAIN, STEP_RAD, recording, three};
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

/// What tells the recordings' noise apart where the last of three has this torque noise, N m: beside a friction that is there, or with nothing
/// missing and nothing named.
fn of_last(noise_nm: f64, named: bool) -> Option<Predictor> {
    let nominal = Model { coulomb: 0.5, torque_delay_s: 0.002, ..Model::new(0.05) };
    let real = Model { viscous: if named { 0.02 } else { 0.0 }, ..nominal.clone() };
    let mut recordings = three(&real, MAKING);
    recordings[2] = recording(&real, Making { noise_nm, ..MAKING }, 3);
    let problem = Problem::new(Physics::new(nominal), recordings, 2, STEP_RAD, false);
    let friction = || Hypothesis::default().with(find("viscous_friction").unwrap(), vec![0.02]);
    let right = if named { friction() } else { Hypothesis::default() };
    let refitted = refit(&problem, &right, &first_noise(&problem), 3).unwrap();
    let step = Step::new(&problem, refitted).unwrap();
    predictors(&problem, &step.assessed.refitted).into_iter().find(|one| one.channel == "recording")
}

#[test]
fn one_noise_is_no_news_and_one_that_is_four_times_as_large_is() {
    assert_eq!(of_last(MAKING.noise_nm, true), None);
    assert_eq!(of_last(1.2 * MAKING.noise_nm, true), None);
    let found = of_last(4.0 * MAKING.noise_nm, true).unwrap();
    println!("{found:?}");
    // Densities of 1, 1 and 16: the least is a sixth of their mean.
    assert!((found.share - 5.0 / 6.0).abs() < 0.05 && found.p_value < 1e-4, "{found:?}");
}

#[test]
fn where_nothing_is_named_it_must_be_much_beside_the_drive() {
    // Over 0.2 s of rows of 1 ms a fourteenth of it is left, beside a drive of 2.1 N m rms: 0.7 and 7 %.
    assert_eq!(of_last(0.2, false), None);
    let found = of_last(2.0, false).unwrap();
    assert!(found.share > 0.95 && found.p_value < 1e-4, "{found:?}");
}
