//! Time of a diagnosis with the whole vocabulary on three recordings of 8 s at 2 kHz, two to fit and one held out: once of machines
//! that lack each of the effects in turn, with the median, the worst and the memory, and often of two of them, with what each stage
//! took. `cargo bench -p lab --bench diagnosis`
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;
use std::time::{Duration, Instant};

use analysis::simulate::{Reference, Setup, record, run};
use criterion::{Criterion, criterion_group, criterion_main};
use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use er_servo::Config;
use er_servo::experiment::{Experiment, Shape};
use lab::conclude::{Request, diagnose};
use lab::guide;
use lab::read::{Axis, AxisKind, ErNominal, Machine, PlantNominal, Recording};
use lab::report::Answer;

fn machine() -> Machine {
    Machine {
        file: "machine.toml".into(),
        name: "er-dd-servo".to_owned(),
        axis: Axis { kind: AxisKind::Rotary, sample_period_s: 5e-4, resolution: std::f64::consts::TAU / 491_520.0 },
        plant: PlantNominal {
            inertia: 0.075,
            coulomb: 0.763,
            viscous: 0.0,
            torque_gain: 1.0,
            torque_offset: 0.0,
            torque_limit: Some(30.0),
            sample_to_output_s: 0.0,
            torque_delay_s: 0.005,
            er: Some(ErNominal { a: 0.0704, b: 0.470, dead_time_s: 0.002, lag_s: 0.003, fluid: None }),
        },
        controller: None,
        columns: Default::default(),
        effects: Vec::new(),
    }
}

/// Steps, a multisine and other steps of the true machine, with torque noise.
fn recordings(truth: &Physics) -> Vec<Recording> {
    let shapes = [
        Shape::Steps { amplitude_rad: 0.9, dwell_s: 0.5, seed: 1 },
        Shape::Multisine { amplitude_rad: 0.5, low_hz: 0.2, high_hz: 3.0, tones: 8 },
        Shape::Steps { amplitude_rad: 0.6, dwell_s: 0.4, seed: 77 },
    ];
    let record = |(seed, shape)| {
        let setup = Setup {
            model: truth.model_of(0),
            config: Config::default(),
            disturbances: Vec::new(),
            sensor_noise_rad: 0.0,
            torque_noise_nm: 0.05,
            seed,
        };
        let reference = Reference::Experiment(Experiment { shape, duration_s: 8.0 });
        record("a.csv", &run(&setup, reference.positions(5e-4).unwrap()).unwrap())
    };
    (1..).zip(shapes).map(record).collect()
}

fn one_missing_effect(c: &mut Criterion) {
    let machine = machine();
    let mut group = c.benchmark_group("diagnosis");
    group.sample_size(10).measurement_time(Duration::from_secs(30));
    for (name, lag_s) in [("nothing_missing", 0.003), ("field_lag", 0.008)] {
        let mut truth = Physics::nominal(&machine, &[]);
        truth.with_field(|field| (field.rise_s, field.fall_s) = (lag_s, lag_s));
        let files = recordings(&truth);
        let (recordings, holdout) = files.split_at(2);
        let request = Request { machine: &machine, recordings, holdout, vocabulary: &VOCABULARY };
        let once = diagnose(&request).unwrap();
        println!("{name}: {:?}", once.answer.verdict);
        for (stage, took) in once.stages.taken() {
            println!("    {stage:24} {:6.3} s", took.as_secs_f64());
        }
        group.bench_function(name, |b| b.iter(|| black_box(diagnose(&request).unwrap())));
    }
    group.finish();
}

/// Once of each effect: what it took as a whole on all cores.
fn every_effect(_: &mut Criterion) {
    let machine = machine();
    let mut all_s = Vec::new();
    println!("effect                  verdict    first                        s");
    for (effect, values) in guide::clear() {
        let mut truth = Physics::nominal(&machine, &[]);
        (effect.put)(&mut truth, &values);
        let files = recordings(&truth);
        let (recordings, holdout) = files.split_at(2);
        let request = Request { machine: &machine, recordings, holdout, vocabulary: &VOCABULARY };
        let began = Instant::now();
        let Answer { verdict, effects, .. } = diagnose(&request).unwrap().answer;
        let took_s = began.elapsed().as_secs_f64();
        let first = effects.first().map_or("-", |effect| effect.id.as_str());
        println!("{:22}  {:9}  {first:22}  {took_s:7.2}", effect.id, format!("{verdict:?}").to_lowercase());
        all_s.push(took_s);
    }
    all_s.sort_by(f64::total_cmp);
    let (median_s, worst_s) = (all_s[all_s.len() / 2], all_s[all_s.len() - 1]);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    println!(
        "{} effects on {cores} cores: median {median_s:.2} s, worst {worst_s:.2} s; {}",
        all_s.len(),
        most_memory()
    );
}

/// The most memory that this process has had, as Linux counts it.
fn most_memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.map_or("memory not counted here".to_owned(), |kilobytes| format!("memory at most {}", kilobytes.trim()))
}

criterion_group!(benches, every_effect, one_missing_effect);
criterion_main!(benches);
