//! What several tests share: recordings of the plant under open-loop torques.
#![allow(clippy::unwrap_used)]

use diagnosis::recorded::Recorded;
use plant::sensor::{Sampler, SamplerConfig, TorqueNoise};
use plant::{Command, Model, Plant, State};

/// Time from row to row, s.
const PERIOD_S: f64 = 1e-3;
/// Sensor step of the servo's resolver, rad.
pub const STEP_RAD: f64 = 1.28e-5;

/// How a recording is made.
#[derive(Debug, Clone, Copy)]
pub struct Making {
    /// Commanded torque, N m, over time, s, and phase, rad.
    pub torque: fn(f64, f64) -> f64,
    /// Its length, s.
    pub seconds: f64,
    /// Torque noise, N m.
    pub noise_nm: f64,
    /// Step of the sensor, rad.
    pub step_rad: f64,
}

/// A recording of a machine; the seed is the phase of its torque too.
pub fn recording(model: &Model, making: Making, seed: u64) -> Recorded {
    let Making { torque, seconds, noise_nm, step_rad } = making;
    let mut plant = Plant::new(model, State::default(), 0.0).unwrap();
    let sampler = SamplerConfig { resolution: step_rad, noise_sd: 0.3 * step_rad, ..SamplerConfig::default() };
    let mut sampler = Sampler::new(sampler, seed).unwrap();
    let mut noise = TorqueNoise::new(noise_nm, seed).unwrap();
    let rows = (seconds / PERIOD_S) as usize;
    let (mut t_s, mut position, mut commands) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..rows {
        let at_s = row as f64 * PERIOD_S;
        let command = Command::new(torque(at_s, seed as f64), 0.0);
        t_s.push(at_s);
        position.push(sampler.measure(plant.state().position));
        commands.push(command);
        plant.advance(&Command { external_torque: noise.draw(), ..command }, at_s + PERIOD_S).unwrap();
    }
    Recorded {
        name: format!("{seed}"),
        skipped: vec![false; rows],
        after_gap: vec![false; rows],
        t_s,
        position,
        commands,
    }
}
