//! What several tests of the closed loop share: the folder of references, the machine of the paper, the true-speed law.
#![allow(dead_code, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::{Path, PathBuf};

use analysis::simulate::{Disturbance, Row, Setup, run};
use er_servo::{Config, Counts};
use plant::{Er, FieldResponse, FluidResponse, Model};

/// Control period, s.
pub const PERIOD_S: f64 = 0.0005;

/// A folder of `shared` beside the repository; none, with the reason printed, where it is not there.
pub fn shared(folder: &str) -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    // A worktree may lie one folder deeper than the main one.
    let candidates = ["../shared", "../../shared"].map(|shared| root.join(shared).join(folder));
    let found = candidates.into_iter().find(|candidate| candidate.is_dir());
    if found.is_none() {
        println!("skipped: the folder ../shared/{folder} is not there");
    }
    found
}

/// A fluid whose field waits, lags or both, s.
pub fn field(dead_time_s: f64, lag_s: f64) -> FluidResponse {
    FluidResponse::Field(FieldResponse::new(dead_time_s, lag_s))
}

/// A fluid whose viscosity waits, s; without a bound, as printed: section 7's rows of Q belong to that reading.
pub fn q_dead(dead_time_s: f64) -> FluidResponse {
    FluidResponse::ViscosityDeadTime { dead_time_s, torque_limit: f64::INFINITY }
}

/// A fluid whose viscosity lags, s; without a bound.
pub fn q_lag(lag_s: f64) -> FluidResponse {
    FluidResponse::ViscosityLag { lag_s, torque_limit: f64::INFINITY }
}

/// The servo of the paper with a fluid.
pub fn paper(response: FluidResponse) -> Model {
    Model { er: Some(Er { response, ..Er::new(0.0704, 0.470, 0.0, 0.0) }), ..Model::paper() }
}

/// The law as control.md section 7 runs it: true speed, strict brake without dead-band.
pub fn true_speed() -> Config {
    Config { speed_from_converter: true, brake_deadband_rad_s: 0.0, ..Config::default() }
}

/// A quiet setup.
pub fn setup(model: Model, config: Config) -> Setup {
    Setup { model, config, disturbances: Vec::new(), sensor_noise_rad: 0.0, torque_noise_nm: 0.0, seed: 1 }
}

/// The loop after a step of its reference at time 0.
pub fn step_response(model: Model, config: Config, height_rad: f64, ticks: usize) -> Vec<Row> {
    run(&setup(model, config), std::iter::repeat_n(Counts::from_rad(height_rad), ticks)).unwrap()
}

/// The loop at rest under the push of control.md section 7: 8 N m for 50 ms.
pub fn pushed(model: Model, config: Config, ticks: usize) -> Vec<Row> {
    let push = Disturbance { start_s: 0.1, duration_s: 0.05, torque_nm: 8.0 };
    let setup = Setup { disturbances: vec![push], ..setup(model, config) };
    run(&setup, std::iter::repeat_n(Counts(0), ticks)).unwrap()
}
