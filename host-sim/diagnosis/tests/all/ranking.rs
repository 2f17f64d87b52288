//! Hypotheses side by side.

use crate::common::{Making, PLAIN, STEP_RAD, three};
use diagnosis::confidence_set::Comparison;
use diagnosis::effects::find;
use diagnosis::hypothesis::Hypothesis;
use diagnosis::physics::Physics;
use diagnosis::problem::Problem;
use diagnosis::ranking::{Contender, rank};
use plant::Model;

/// Four seconds of motion, then rest.
fn torque(t_s: f64, phase: f64) -> f64 {
    if t_s < 4.0 { 2.5 * (3.1 * t_s + phase).sin() + 1.5 * (11.0 * t_s + 2.0 * phase).sin() } else { 0.0 }
}

/// Of two hypotheses that both miss something of the motion, how much better the better one is.
fn compared(rest_s: f64) -> Comparison {
    let machine = Model { coulomb: 0.5, torque_delay_s: 0.002, ..Model::new(0.05) };
    // Drag between linear and square, which is neither.
    let beside = |_: f64, speed: f64| -0.02 * speed * speed.abs().sqrt();
    let recordings = three(&machine, Making { torque, beside, seconds: 4.0 + rest_s, ..PLAIN });
    let problem = Problem::new(Physics::new(machine), recordings, 2, STEP_RAD, false);
    let contender = |name: &'static str| {
        let effect = find(name).unwrap();
        let starts = (effect.starts)(&problem.nominal, &problem.excitation);
        Contender {
            name,
            starts: starts.into_iter().map(|values| Hypothesis::default().with(effect, values)).collect(),
        }
    };
    let ranked = rank(&problem, &[contender("viscous_friction"), contender("quadratic_drag")], || ());
    println!("{rest_s} s of rest: {} is better by {:?}", ranked[0].name, ranked[1].behind);
    ranked[1].behind.unwrap()
}

/// At rest both predict the same. At a noise of its own each, the smaller noise was likelier in every block of it.
#[test]
fn how_long_an_axis_rests_tells_nothing_of_what_moves_it() {
    let (short, long) = (compared(2.0), compared(12.0));
    assert!(long.rank_z <= short.rank_z && long.window_z <= short.window_z, "{short:?} {long:?}");
}
