//! What a model leaves unexplained: little of its own recordings, and on real machines what is known to be in them.

use std::path::Path;

use crate::servo::{PERIOD_S, field, paper, setup, shared};
use analysis::simulate::{Reference, Setup, record, run};
use diagnosis::physics::Physics;
use er_servo::experiment::{Experiment, Shape};
use er_servo::{Config, RAD_PER_COUNT};
use lab::read::{Axis, AxisKind, Machine, Recording};
use lab::report::compare::{Comparison, HORIZON_S};
use lab::residual::{Channel, residual, sensor_noise};
use plant::Model;

fn axis() -> Axis {
    Axis { kind: AxisKind::Rotary, sample_period_s: PERIOD_S, resolution: f64::from(RAD_PER_COUNT) }
}

/// Eight seconds of steps; every channel is driven.
fn recording(model: Model, sensor_noise_rad: f64) -> Recording {
    let shape = Shape::Steps { amplitude_rad: 0.4, dwell_s: 0.25, seed: 1 };
    let reference = Reference::Experiment(Experiment { shape, duration_s: 8.0 });
    let setup = Setup { sensor_noise_rad, ..setup(model, Config::default()) };
    record("synthetic.csv", &run(&setup, reference.positions(PERIOD_S).unwrap()).unwrap())
}

#[test]
fn a_machine_that_is_its_model_leaves_the_noise_of_the_sensor() {
    let model = paper(field(0.002, 0.003));
    for noise_rad in [0.0, 5e-5] {
        let recording = recording(model.clone(), noise_rad);
        let noise = sensor_noise(&recording, &axis());
        // Rounding to whole counts is a noise of its own.
        let truth = noise_rad.hypot(f64::from(RAD_PER_COUNT) / 12.0_f64.sqrt());
        assert!((noise / truth - 1.0).abs() < 0.1, "noise {noise:e}, in truth {truth:e}");
        for horizon_s in [HORIZON_S, 4.0 * HORIZON_S] {
            let residual = residual(&model, &recording, horizon_s).unwrap();
            let ratio = residual.rms() / truth;
            println!("noise {truth:.2e} rad, {horizon_s} s windows: residual {ratio:.3} times that");
            // The start state takes two of 100 or 400 degrees of freedom.
            assert!((0.9..1.1).contains(&ratio), "{ratio}");
        }
    }
}

#[test]
fn what_is_left_out_of_the_model_shows_in_its_channel() {
    let axis = axis();
    let viscous = recording(Model { viscous: 0.25, ..paper(field(0.002, 0.003)) }, 0.0);
    let nominal = paper(field(0.002, 0.003));
    let comparison = Comparison::new(&nominal, &axis, &viscous).unwrap();
    println!("{comparison}");
    let others = [Channel::Position, Channel::Field, Channel::Time].map(|channel| comparison.explained(channel));
    let speed = comparison.explained(Channel::Speed);
    assert!(speed > 0.7 && others.iter().all(|other| *other < speed), "{speed}, {others:?}");

    let complete = recording(nominal.clone(), 0.0);
    let clean = Comparison::new(&nominal, &axis, &complete).unwrap();
    assert!(comparison.rms() > 100.0 * clean.rms(), "{} and {}", comparison.rms(), clean.rms());
}

#[test]
fn no_residual_is_taken_across_a_gap() {
    let model = paper(field(0.002, 0.003));
    let mut torn = recording(model.clone(), 0.0);
    // As a reader finds it: rows 4000 and on are 30 ms later than the row before.
    torn.t_s.iter_mut().skip(4000).for_each(|t_s| *t_s += 0.03);
    torn.gaps = vec![3999];
    let residual = residual(&model, &torn, 0.05).unwrap();
    assert!(residual.windows.iter().all(|window| window.end <= 4000 || window.start >= 4000));
    // What was commanded in the gap acts for 30 ms behind it: 60 rows.
    let anew = residual.windows.iter().map(|window| window.start).find(|start| *start >= 4000);
    assert_eq!(anew, Some(4060), "windows begin anew after the gap");
}

/// Shares of the residual on a real machine.
struct Shares {
    direction: f64,
    speed: f64,
    /// Orders named, and their share together.
    orders: Option<(Vec<u32>, f64)>,
}

fn on_real_machine(folder: &str, file: &str) -> Option<Shares> {
    let data = shared("data")?.join(folder);
    let machine = Machine::read(&data.join("machine.toml")).unwrap();
    let recording = Recording::read(&data.join(file), Some(machine.axis.kind)).unwrap();
    let comparison = Comparison::new(&Physics::nominal(&machine, &[]).model_of(0), &machine.axis, &recording).unwrap();
    println!("{comparison}");
    let orders = comparison.orders().map(|found| (found.orders.iter().map(|o| o.per_rev).collect(), found.explained));
    let picture = tempfile::tempdir().unwrap();
    let svg = picture.path().join("compare.svg");
    comparison.figure(file, None).write(&svg).unwrap();
    assert!(Path::new(&svg).metadata().unwrap().len() > 10_000, "a picture with something in it");
    let (direction, speed) = (comparison.explained(Channel::Direction), comparison.explained(Channel::Speed));
    Some(Shares { direction, speed, orders })
}

#[test]
fn the_linear_axis_without_its_friction_follows_the_direction() {
    for file in ["train.csv", "pulses.csv"] {
        let Some(Shares { direction, speed, orders }) = on_real_machine("emps", file) else { return };
        assert!(direction > 0.9 && speed > 0.9, "{file}: direction {direction}, speed {speed}");
        assert_eq!(orders, None, "a linear axis has no orders");
    }
}

#[test]
fn the_direct_drive_without_its_cogging_follows_the_position() {
    for run in [
        "slow2_comp_0",
        "slow2_nocomp_0",
        "slow2_nocomp_1",
        "slow2_nocomp_2",
        "slow2_slower_comp_0",
        "slow2_slower_nocomp_0",
    ] {
        let Some(Shares { direction, speed, orders }) = on_real_machine("odrive_cogging", &format!("{run}.csv")) else {
            return;
        };
        let (orders, explained) = orders.expect("more than a revolution is in the recording");
        println!("{run}: orders {orders:?} {explained}, speed {speed}, direction {direction}");
        assert!(orders.contains(&7), "{run}: {orders:?}");
        assert!(explained > 0.5 && explained > speed, "{run}: orders {explained}, speed {speed}");
    }
}
