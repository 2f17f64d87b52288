//! A fluid that warms, one whose lag depends on its field, one that flows and a torque column that is stamped late beside a fluid: left out of
//! the model, each is named first with its values.

use crate::common::{Making, PLAIN, STEP_RAD, three};
use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use diagnosis::pipeline::{Conclusion, diagnose};
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use plant::effects::Warming;
use plant::er_fluid::{FlowCurve, Kinetics};
use plant::{Er, FieldResponse, FluidResponse, Model};

/// Torques of every size that move either way against the fluid, and rest.
fn torque(t_s: f64, phase: f64) -> f64 {
    let slow = 0.7 + 0.3 * (0.9 * t_s + phase).sin();
    slow * (4.0 * (3.1 * t_s + phase).sin() + 2.0 * (11.0 * t_s + 2.0 * phase).sin())
}

/// Levels that rise and fall, weak and strong, each for a tenth of a second.
fn levels(t_s: f64, phase: f64) -> f64 {
    let index = (10.0 * t_s + 0.5 * phase) as usize % 8;
    [0.0, 2.5, 0.6, 3.3, 0.0, 1.2, 0.3, 1.8][index]
}

fn machine(response: FieldResponse, warming: Option<Warming>) -> Model {
    let er = Er { response: FluidResponse::Field(response), warming, ..Er::new(0.0704, 0.470, 0.0, 0.0) };
    Model { coulomb: 0.3, viscous: 0.1, torque_delay_s: 0.002, er: Some(er), ..Model::new(0.05) }
}

/// What is found in two recordings with a third held out.
fn found(nominal: Model, actual: &Model, seconds: f64) -> Conclusion {
    diagnosed(nominal, three(actual, making(seconds)))
}

fn making(seconds: f64) -> Making {
    Making { torque, field: levels, seconds, step_rad: STEP_RAD, ..PLAIN }
}

fn diagnosed(nominal: Model, recordings: Vec<Recorded>) -> Conclusion {
    let problem = Problem::new(Physics::new(nominal), recordings, 2, STEP_RAD, false);
    let found = diagnose(&problem, &VOCABULARY).unwrap();
    for named in &found.effects {
        let values: Vec<String> =
            named.intervals.iter().map(|i| format!("{:.4} ({:.4} to {:.4})", i.value, i.low, i.high)).collect();
        println!("{:?} {} {} {:?}", found.verdict, named.effect.id, values.join(", "), named.equivalent);
    }
    found
}

/// The first effect is that one, with those values.
fn holds(found: &Conclusion, id: &str, truth: &[f64]) {
    let named = &found.effects[0];
    assert_eq!(named.effect.id, id);
    assert_eq!(named.intervals.len(), truth.len());
    for (interval, truth) in named.intervals.iter().zip(truth) {
        // Four standard deviations: one seed is no coverage.
        let off = (interval.value - truth).abs();
        assert!(off < interval.high - interval.low, "{id}: {interval:?}, is {truth}");
    }
}

const LAG: FieldResponse = FieldResponse {
    dead_time_s: 0.0,
    slew_kv_mm_s: None,
    rise_s: 0.006,
    fall_s: 0.006,
    kinetics: Kinetics { rise_exponent: 0.0, fall_exponent: 0.0 },
    flow: None,
};

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_fluid_that_warms_is_named() {
    let warming = Warming { per_j: 0.02, cooling_per_s: 0.3 };
    let found = found(machine(LAG, None), &machine(LAG, Some(warming)), 8.0);
    holds(&found, "temperature_yield", &[0.02, 0.3]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_lag_that_depends_on_the_field_is_named() {
    let kinetics = Kinetics { rise_exponent: 1.0, fall_exponent: 0.5 };
    let found = found(machine(LAG, None), &machine(FieldResponse { kinetics, ..LAG }, None), 4.0);
    holds(&found, "field_kinetics", &[1.0, 0.5]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_flow_that_the_field_thickens_is_named() {
    let flow = Some(FlowCurve { consistency: 0.0, consistency_per_kv_mm: 0.1, exponent: 0.5 });
    let found = found(machine(LAG, None), &machine(FieldResponse { flow, ..LAG }, None), 4.0);
    holds(&found, "er_flow", &[0.1, 0.5]);
}

/// Only a skew of the channels lets a torque act before its row: a latency would move the field's commands with it.
#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_torque_column_that_is_stamped_late_is_named_beside_a_fluid() {
    const ROWS_LATE: usize = 2;
    let machine = Model { torque_delay_s: 0.0, ..machine(LAG, None) };
    let mut recordings = three(&machine, making(3.0));
    for recorded in &mut recordings {
        let acted: Vec<f64> = recorded.commands.iter().map(|command| command.torque).collect();
        for (row, command) in recorded.commands.iter_mut().enumerate() {
            command.torque = acted[row.saturating_sub(ROWS_LATE)];
        }
    }
    let found = diagnosed(machine, recordings);
    holds(&found, "channel_skew", &[-0.002]);
    assert_eq!(found.effects.len(), 1);
    assert!(found.effects[0].equivalent.is_empty());
}
