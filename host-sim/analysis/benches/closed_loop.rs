//! Time of the closed loop, law and plant, at 2 kHz: ten seconds with the fluid the paper ends on, and one second with each
//! delay model. `cargo bench -p analysis --bench closed_loop`
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;

use analysis::simulate::{ClosedLoop, Reference, Setup, period_s};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use er_servo::experiment::{Experiment, Shape};
use er_servo::{Config, Counts};
use plant::{Er, FieldResponse, FluidResponse, Model};

fn setup(response: FluidResponse) -> Setup {
    Setup {
        model: Model { er: Some(Er { response, ..Er::new(0.0704, 0.470, 0.0, 0.0) }), ..Model::paper() },
        config: Config::default(),
        disturbances: Vec::new(),
        sensor_noise_rad: 0.0,
        torque_noise_nm: 0.0,
        seed: 1,
    }
}

fn field(dead_time_s: f64, lag_s: f64) -> FluidResponse {
    FluidResponse::Field(FieldResponse::new(dead_time_s, lag_s))
}

fn positions(shape: Shape, duration_s: f32) -> Vec<Counts> {
    let reference = Reference::Experiment(Experiment { shape, duration_s });
    reference.positions(period_s(&Config::default())).unwrap().collect()
}

/// Steps that leave little rest between them.
fn steps(duration_s: f32) -> Vec<Counts> {
    positions(Shape::Steps { amplitude_rad: 0.5, dwell_s: 0.25, seed: 1 }, duration_s)
}

/// The last position, so that nothing is optimised away; no recording is built.
fn run(setup: &Setup, reference: &[Counts]) -> f64 {
    let mut closed_loop = ClosedLoop::new(setup).unwrap();
    reference.iter().fold(0.0, |_, counts| closed_loop.tick(*counts).unwrap().truth.position)
}

fn ten_seconds(c: &mut Criterion) {
    let mut group = c.benchmark_group("closed_loop_ten_seconds");
    let setup = setup(field(0.002, 0.003));
    let multisine = Shape::Multisine { amplitude_rad: 0.2, low_hz: 0.2, high_hz: 8.0, tones: 16 };
    for (name, reference) in [
        ("step", positions(Shape::Step { amplitude_rad: std::f32::consts::FRAC_PI_6 }, 10.0)),
        ("steps", steps(10.0)),
        ("multisine", positions(multisine, 10.0)),
    ] {
        group.throughput(Throughput::Elements(reference.len() as u64));
        group.bench_function(name, |b| b.iter(|| black_box(run(&setup, &reference))));
    }
    group.finish();
}

fn each_delay_model(c: &mut Criterion) {
    let mut group = c.benchmark_group("closed_loop_one_second");
    let torque_limit = f64::INFINITY;
    let reference = steps(1.0);
    group.throughput(Throughput::Elements(reference.len() as u64));
    for (name, response) in [
        ("none", field(0.0, 0.0)),
        ("field_dead_5", field(0.005, 0.0)),
        ("field_lag_5", field(0.0, 0.005)),
        ("field_dead_2_lag_3", field(0.002, 0.003)),
        ("q_dead_5", FluidResponse::ViscosityDeadTime { dead_time_s: 0.005, torque_limit }),
        ("q_lag_5", FluidResponse::ViscosityLag { lag_s: 0.005, torque_limit }),
    ] {
        let setup = setup(response);
        group.bench_function(name, |b| b.iter(|| black_box(run(&setup, &reference))));
    }
    group.finish();
}

criterion_group!(benches, ten_seconds, each_delay_model);
criterion_main!(benches);
