//! Recordings with something left out of the model.

use analysis::simulate::{Reference, Setup, record, run};
use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use er_servo::Config;
use er_servo::experiment::{Experiment, Shape};
use lab::conclude::{Request, diagnose};
use lab::read::{Axis, AxisKind, ErNominal, Machine, PlantNominal, Recording};
use lab::report::Answer;

/// The default machine of the specification.
pub fn machine(resolution: f64) -> Machine {
    Machine {
        file: "machine.toml".into(),
        name: "er-dd-servo".to_owned(),
        axis: Axis { kind: AxisKind::Rotary, sample_period_s: 5e-4, resolution },
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

/// Step of the resolver, rad.
pub const COUNT_RAD: f64 = std::f64::consts::TAU / 491_520.0;

/// The default machine in numbers.
pub fn nominal() -> Physics {
    Physics::nominal(&machine(COUNT_RAD), &[])
}

/// Three recordings of 8 s of a machine: two to fit, one held out.
pub fn recordings(change: &dyn Fn(&mut Physics), seed: u64, torque_noise_nm: f64) -> Vec<Recording> {
    let mut physics = nominal();
    change(&mut physics);
    recorded(&physics, seed, torque_noise_nm, 8.0)
}

/// The same of a given length.
pub fn recorded(physics: &Physics, seed: u64, torque_noise_nm: f64, duration_s: f32) -> Vec<Recording> {
    let shapes = [
        Shape::Steps { amplitude_rad: 0.9, dwell_s: 0.5, seed: seed as u32 + 1 },
        Shape::Multisine { amplitude_rad: 0.5, low_hz: 0.2, high_hz: 3.0, tones: 8 },
        Shape::Steps { amplitude_rad: 0.6, dwell_s: 0.4, seed: seed as u32 + 77 },
    ];
    recorded_as(physics, shapes, seed, torque_noise_nm, duration_s)
}

/// The same over other references.
pub fn recorded_as(
    physics: &Physics,
    shapes: [Shape; 3],
    seed: u64,
    torque_noise_nm: f64,
    duration_s: f32,
) -> Vec<Recording> {
    let named = shapes.into_iter().zip(["a.csv", "b.csv", "c.csv"]).enumerate();
    let record_one = |(index, (shape, name)): (usize, (Shape, &str))| {
        let setup = Setup {
            model: physics.model_of(index),
            config: Config::default(),
            disturbances: Vec::new(),
            sensor_noise_rad: 0.0,
            torque_noise_nm,
            seed: seed * 10 + index as u64,
        };
        let reference = Reference::Experiment(Experiment { shape, duration_s });
        record(name, &run(&setup, reference.positions(5e-4).unwrap()).unwrap())
    };
    named.map(record_one).collect()
}

/// Diagnoses two recordings with the third held out.
pub fn answer(recordings: &[Recording], without: &str) -> Answer {
    let vocabulary: Vec<_> = VOCABULARY.iter().copied().filter(|effect| effect.id != without).collect();
    let machine = machine(COUNT_RAD);
    let request =
        Request { machine: &machine, recordings: &recordings[..2], holdout: &recordings[2..], vocabulary: &vocabulary };
    diagnose(&request).unwrap().answer
}
