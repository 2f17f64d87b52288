//! Orders over position of a linear axis, which has no whole ones: left out of the model, one ripple is one effect at its own order.

use std::f64::consts::TAU;

use crate::common::{Making, PLAIN, STEP_RAD, three};
use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use diagnosis::pipeline::diagnose;
use diagnosis::problem::Problem;
use plant::Model;
use plant::effects::Harmonic;

/// Torques that move it to and fro, and rest.
fn torque(t_s: f64, phase: f64) -> f64 {
    let slow = 0.6 + 0.4 * (0.9 * t_s + phase).sin();
    slow * (2.5 * (3.1 * t_s + phase).sin() + 1.5 * (11.0 * t_s + 2.0 * phase).sin())
}

fn machine() -> Model {
    Model { coulomb: 0.5, viscous: 0.1, torque_delay_s: 0.002, ..Model::new(0.05) }
}

/// Orders at which the diagnosis names an effect of that kind, and of how many effects in all; two recordings fitted and one held out.
fn orders(actual: &Model, id: &str, order: f64) {
    let making = Making { torque, seconds: 4.0, noise_nm: 0.02, step_rad: STEP_RAD, ..PLAIN };
    let recordings = three(actual, making);
    let problem = Problem::new(Physics::new(machine()), recordings, 2, STEP_RAD, true);
    let apart = TAU / problem.excitation.travel;
    let found = diagnose(&problem, &VOCABULARY).unwrap();
    let named: Vec<(&str, f64)> = found.effects.iter().map(|named| (named.effect.id, named.entry.values[0])).collect();
    println!("{named:?} for {id} of {order}, where {apart:.3} is told apart");
    assert_eq!(named.len(), 1, "{named:?}");
    assert_eq!(named[0].0, id);
    assert!((named[0].1 - order).abs() < 0.05 * apart, "{named:?}, is {order}, {apart} apart");
    // Amplitude, order and phase.
    let found = found.effects[0].intervals[1];
    println!("{:.4} ({:.4} to {:.4})", found.value, found.low, found.high);
    assert!(found.low < order && order < found.high && found.high - found.low < 0.1 * apart, "{found:?}");
}

#[test]
fn a_ripple_between_two_orders_is_one() {
    let ripple =
        |order| Model { torque_ripple: vec![Harmonic { amplitude: 0.08, order, phase_rad: 0.7 }], ..machine() };
    orders(&ripple(5.3), "torque_ripple", 5.3);
}

#[test]
fn a_cogging_between_two_orders_is_one() {
    let cogging = |order| Model { cogging: vec![Harmonic { amplitude: 0.2, order, phase_rad: -1.1 }], ..machine() };
    orders(&cogging(7.45), "cogging", 7.45);
}
