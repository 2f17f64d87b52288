//! Friction over the load, warming and a drive's ripple: left out of the model, each is named first with its value.

use crate::common::{Making, PLAIN, STEP_RAD, three};
use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use diagnosis::pipeline::{Named, diagnose};
use diagnosis::problem::Problem;
use plant::Model;
use plant::effects::{Harmonic, Warming};

/// Torque noise, N m.
const NOISE_NM: f64 = 0.02;

/// Torques of every size that move either way, rest and reverse.
fn torque(t_s: f64, phase: f64) -> f64 {
    let slow = 0.6 + 0.4 * (0.9 * t_s + phase).sin();
    slow * (2.5 * (3.1 * t_s + phase).sin() + 1.5 * (11.0 * t_s + 2.0 * phase).sin())
        + if (t_s * 1.3) % 1.0 < 0.2 { 0.0 } else { 0.4 }
}

fn machine() -> Model {
    Model { coulomb: 0.5, viscous: 0.1, torque_delay_s: 0.002, ..Model::new(0.05) }
}

/// What the diagnosis names first, two recordings fitted and one held out.
fn first(actual: &Model, seconds: f64) -> Named {
    let making = Making { torque, seconds, noise_nm: NOISE_NM, step_rad: STEP_RAD, ..PLAIN };
    let recordings = three(actual, making);
    let problem = Problem::new(Physics::new(machine()), recordings, 2, STEP_RAD, false);
    let found = diagnose(&problem, &VOCABULARY).unwrap();
    for named in &found.effects {
        let values: Vec<String> =
            named.intervals.iter().map(|i| format!("{:.4} ({:.4} to {:.4})", i.value, i.low, i.high)).collect();
        println!("{:?} {} {} {:?}", found.verdict, named.effect.id, values.join(", "), named.equivalent);
    }
    found.effects.into_iter().next().unwrap()
}

fn holds(named: &Named, index: usize, truth: f64) {
    let interval = named.intervals[index];
    // Four standard deviations: one seed is no coverage.
    let off = (interval.value - truth).abs();
    assert!(off < interval.high - interval.low, "{}: {interval:?}, is {truth}", named.effect.id);
}

#[test]
fn friction_over_the_load_is_named() {
    let named = first(&Model { load_friction: 0.08, ..machine() }, 4.0);
    assert_eq!(named.effect.id, "load_dependent_friction");
    holds(&named, 0, 0.08);
}

#[test]
fn a_drives_ripple_is_named() {
    let ripple = Harmonic { amplitude: 0.06, order: 6.0, phase_rad: 0.7 };
    let named = first(&Model { torque_ripple: vec![ripple], ..machine() }, 4.0);
    assert_eq!(named.effect.id, "torque_ripple");
    assert_eq!(named.intervals[1].value, 6.0);
    holds(&named, 0, 0.06);
    holds(&named, 2, 0.7);
}

#[test]
fn a_viscosity_that_warms_is_named() {
    let warming = Warming { per_j: 0.005, cooling_per_s: 0.3 };
    let named = first(&Model { viscous_warming: Some(warming), ..machine() }, 8.0);
    assert_eq!(named.effect.id, "temperature_viscosity");
    holds(&named, 0, 0.005);
    holds(&named, 1, 0.3);
}
