//! Recordings of known machines, for the tests of this stage.
#![allow(clippy::unwrap_used)]

use er_servo::Config;
use er_servo::experiment::{Experiment, Shape};

use crate::effects::Physics;
use crate::read::{Axis, AxisKind, ErNominal, Machine, PlantNominal, Recording};
use crate::refit::model;
use crate::simulate::{Reference, Setup, record, run};

/// The default machine of the specification, with its resolver.
pub(crate) fn machine() -> Machine {
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
            torque_delay_s: 0.005,
            er: Some(ErNominal { a: 0.0704, b: 0.470, dead_time_s: 0.002, lag_s: 0.003 }),
        },
        controller: None,
        columns: Default::default(),
        effects: Vec::new(),
    }
}

/// A machine in closed loop over random steps, with a torque noise, N m.
pub(crate) fn recording(physics: &Physics, torque_noise_nm: f64, duration_s: f32, seed: u64) -> Recording {
    let shape = Shape::Steps { amplitude_rad: 0.9, dwell_s: 0.5, seed: seed as u32 };
    over("steps.csv", Experiment { shape, duration_s }, physics, torque_noise_nm, seed)
}

/// The same over a multisine, which hardly rests and needs the field all the time.
pub(crate) fn multisine(physics: &Physics, torque_noise_nm: f64, duration_s: f32, seed: u64) -> Recording {
    let shape = Shape::Multisine { amplitude_rad: 0.5, low_hz: 0.2, high_hz: 3.0, tones: 8 };
    over("multisine.csv", Experiment { shape, duration_s }, physics, torque_noise_nm, seed)
}

fn over(name: &str, reference: Experiment, physics: &Physics, torque_noise_nm: f64, seed: u64) -> Recording {
    let setup = Setup {
        model: model(physics, 0),
        config: Config::default(),
        disturbances: Vec::new(),
        sensor_noise_rad: 0.0,
        torque_noise_nm,
        seed,
    };
    let reference = Reference::Experiment(reference);
    let positions = reference.positions(5e-4).unwrap();
    record(name, &run(&setup, positions).unwrap())
}
