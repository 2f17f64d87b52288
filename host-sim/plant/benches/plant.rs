//! Time per simulated second of the plant for each delay model: `cargo bench -p plant`.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use plant::{Command, Er, FluidResponse, Mechanics, Model, Plant, State, Timeline};

const TICKS: u32 = 2000;
const TICK_S: f64 = 0.0005;

/// Motion and field of every kind: fast, slow, reversing, stuck. The field is even so that closed loop and recording
/// see changing commands in every tick.
fn command(tick: u32) -> Command {
    let t_s = f64::from(tick) * TICK_S;
    let torque = 4.0 * (17.0 * t_s).sin() + 2.0 * (31.0 * t_s).sin();
    let speed_estimate = 1.5 * (17.0 * t_s).cos();
    Command { speed_estimate, ..Command::new(torque, 1.5 + 1.4 * (23.0 * t_s).sin()) }
}

fn paper_with(response: FluidResponse) -> Model {
    Model { er: Some(Er { response, ..Er::new(0.0704, 0.470, 0.0, 0.0) }), ..Model::paper() }
}

fn field(dead_time_s: f64, lag_s: f64) -> Model {
    Model { er: Some(Er::new(0.0704, 0.470, dead_time_s, lag_s)), ..Model::paper() }
}

fn delay_models() -> Vec<(&'static str, Model)> {
    let torque_limit = 2.5074;
    vec![
        ("none", field(0.0, 0.0)),
        ("field_dead_5", field(0.005, 0.0)),
        ("field_lag_5", field(0.0, 0.005)),
        ("field_dead_2_lag_3", field(0.002, 0.003)),
        ("field_dead_2.2_lag_3", field(0.0022, 0.003)),
        ("field_dead_2_lag_3_viscous", Model { viscous: 0.1, ..field(0.002, 0.003) }),
        ("q_dead_5", paper_with(FluidResponse::ViscosityDeadTime { dead_time_s: 0.005, torque_limit })),
        ("q_lag_5", paper_with(FluidResponse::ViscosityLag { lag_s: 0.005, torque_limit })),
    ]
}

fn closed_loop(c: &mut Criterion) {
    let mut group = c.benchmark_group("closed_loop_one_second");
    group.throughput(Throughput::Elements(u64::from(TICKS)));
    let commands: Vec<Command> = (0..TICKS).map(command).collect();
    for (name, model) in delay_models() {
        group.bench_function(name, |b| {
            b.iter(|| {
                let mut plant = Plant::new(&model, State::default(), 0.0).unwrap();
                for (tick, command) in (1..).zip(&commands) {
                    plant.advance(command, f64::from(tick) * TICK_S).unwrap();
                }
                black_box(plant.state().position)
            });
        });
    }
    group.finish();
}

fn open_loop(c: &mut Criterion) {
    let mut group = c.benchmark_group("open_loop_one_second");
    group.throughput(Throughput::Elements(u64::from(TICKS)));
    let times_s: Vec<f64> = (0..TICKS).map(|tick| f64::from(tick) * TICK_S).collect();
    let commands: Vec<Command> = (0..TICKS).map(command).collect();
    let mut positions = vec![0.0; times_s.len()];
    for (name, model) in delay_models() {
        let timeline = Timeline::new(&model, &times_s, &commands, &Command::default()).unwrap();
        let mechanics = Mechanics::new(&model).unwrap();
        group.bench_function(name, |b| {
            b.iter(|| {
                mechanics.simulate(&timeline, 0.0, State::default(), &times_s, black_box(&mut positions)).unwrap()
            });
        });
    }
    group.finish();
}

criterion_group!(benches, closed_loop, open_loop);
criterion_main!(benches);
