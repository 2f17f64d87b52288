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
    /// Commanded field, kV/mm, over the same.
    pub field: fn(f64, f64) -> f64,
    /// Its length, s.
    pub seconds: f64,
    /// Torque noise, N m.
    pub noise_nm: f64,
    /// Step of the sensor, rad.
    pub step_rad: f64,
    /// Standard deviation, N m, and memory, s, of torque noise that decays at random.
    pub coloured: (f64, f64),
    /// Torque, N m, that no model has, over time, s, and speed, rad/s.
    pub beside: fn(f64, f64) -> f64,
}

/// Four seconds at rest, with the servo's sensor and a little noise; a test overrides what it is about.
pub const PLAIN: Making = Making {
    torque: |_, _| 0.0,
    field: |_, _| 0.0,
    seconds: 4.0,
    noise_nm: 0.02,
    step_rad: STEP_RAD,
    coloured: (0.0, 1.0),
    beside: |_, _| 0.0,
};

/// Three recordings of a machine, of seeds 1 to 3.
pub fn three(model: &Model, making: Making) -> Vec<Recorded> {
    (1..=3).map(|seed| recording(model, making, seed)).collect()
}

/// A recording of a machine; the seed is the phase of its torque too.
pub fn recording(model: &Model, making: Making, seed: u64) -> Recorded {
    let Making { torque, field, seconds, noise_nm, step_rad, coloured: (coloured_nm, memory_s), beside } = making;
    let mut plant = Plant::new(model, State::default(), 0.0).unwrap();
    let sampler = SamplerConfig { resolution: step_rad, noise_sd: 0.3 * step_rad, ..SamplerConfig::default() };
    let mut sampler = Sampler::new(sampler, seed).unwrap();
    let mut noise = TorqueNoise::new(noise_nm, seed).unwrap();
    let kept = (-PERIOD_S / memory_s).exp();
    let mut stirred = TorqueNoise::new(coloured_nm * (1.0 - kept * kept).sqrt(), seed + 1000).unwrap();
    let mut coloured = 0.0;
    let rows = (seconds / PERIOD_S) as usize;
    let (mut t_s, mut position, mut commands) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..rows {
        let at_s = row as f64 * PERIOD_S;
        let command = Command::new(torque(at_s, seed as f64), field(at_s, seed as f64));
        t_s.push(at_s);
        position.push(sampler.measure(plant.state().position));
        commands.push(command);
        coloured = kept * coloured + stirred.draw();
        let external_torque = noise.draw() + coloured + beside(at_s, plant.state().velocity);
        plant.advance(&Command { external_torque, ..command }, at_s + PERIOD_S).unwrap();
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
