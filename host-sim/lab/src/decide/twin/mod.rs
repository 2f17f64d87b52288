//! Clean synthetic twins: what a machine that is exactly the improved one would have recorded.
//!
//! A twin follows the recorded motion with the recorded commands plus a small correction, at the same times, under the
//! same field and mode, with torque and sensor noise as estimated from the recording. Nothing is missing from its model,
//! so what the windows leave of it is the noise floor, and what the search finds in it is false.

mod clean;
mod floor;
mod noise;
#[cfg(test)]
mod tests;
mod verdict;

use plant::sensor::{Sampler, SamplerConfig, TorqueNoise};
use plant::{Command, Model, Plant, State};

pub use clean::falsely_found;
pub use floor::{Above, Floor, noise_floor};
pub use noise::{Noise, estimate};
pub use verdict::Twins;

use crate::Error;
use crate::effects::Physics;
use crate::read::Recording;
use crate::refit::model;
use crate::residual::recorded_commands;
use crate::screen::Motion;

/// The motion that a twin follows.
#[derive(Debug, Clone, Copy)]
pub struct Path<'a> {
    /// At the rows, rad (m).
    pub position: &'a [f64],
    /// At the rows, rad/s (m/s).
    pub speed: &'a [f64],
    /// Median sample period, s.
    pub period_s: f64,
}

impl<'a> Path<'a> {
    /// Rows `from..to` of a smoothed motion.
    pub fn of(motion: &'a Motion, from: usize, to: usize) -> Self {
        Self { position: &motion.smooth[from..to], speed: &motion.speed[from..to], period_s: motion.period_s }
    }
}

/// Bandwidth of the correction, rad/s, where no delay allows less: it holds the twin near, it does not drive it.
const BANDWIDTH_RAD_S: f64 = 40.0;
/// The correction may lose this phase in the delays of the drive, rad.
const PHASE_RAD: f64 = 0.3;

/// Gains of the correction.
struct Correction {
    stiffness: f64,
    damping: f64,
    /// No command is larger than the largest recorded: that would be another excitation.
    peak: f64,
}

impl Correction {
    /// Critically damped, its crossover at twice the bandwidth.
    fn of(machine: &Physics, recording: &Recording, period_s: f64) -> Self {
        let late_s = machine.torque_delay_s + machine.torque_lag_s + period_s;
        let shaft = machine.load.map_or(f64::INFINITY, |load| 0.5 * load.resonance_hz);
        let bandwidth = BANDWIDTH_RAD_S.min(0.5 * PHASE_RAD / late_s).min(shaft);
        let inertia = machine.inertia / machine.torque_gain.abs().max(1e-3);
        Self {
            stiffness: inertia * bandwidth * bandwidth,
            damping: 2.0 * inertia * bandwidth,
            peak: recording.effort_cmd.iter().fold(0.0_f64, |peak, u| peak.max(u.abs())),
        }
    }

    fn command(&self, recorded: f64, wanted: State, now: &State) -> f64 {
        let behind =
            self.stiffness * (wanted.position - now.position) + self.damping * (wanted.velocity - now.velocity);
        (recorded + behind).clamp(-self.peak, self.peak)
    }
}

/// The twin of recording number `index` (of the machine's pushes and phases), which moves along `path`.
///
/// # Errors
/// A machine that the plant refuses.
pub fn twin(
    machine: &Physics,
    index: usize,
    recording: &Recording,
    path: Path<'_>,
    noise: &Noise,
    seed: u64,
) -> Result<Recording, Error> {
    let refused = |error: plant::Error| Error::Usage(format!("{}: its twin: {error}", recording.name));
    let model = model(machine, index);
    let sampler = SamplerConfig { resolution: noise.resolution, noise_sd: noise.position, ..SamplerConfig::default() };
    let mut sampler = Sampler::new(sampler, seed).map_err(refused)?;
    let mut torque = TorqueNoise::new(noise.torque, seed.wrapping_add(1 << 32)).map_err(refused)?;
    let mut commands = recorded_commands(recording);
    commands.iter_mut().for_each(|command| command.external_torque = torque.draw());
    let correction = Correction::of(machine, recording, path.period_s);
    let true_position = follow(&model, recording, path, &correction, &mut commands).map_err(refused)?;
    Ok(Recording {
        position: true_position.iter().map(|&q| sampler.measure(q)).collect(),
        effort_cmd: commands.iter().map(|command| command.torque).collect(),
        // The damper was commanded with the recorded estimate of the speed; the twin's damper too.
        velocity: Some(commands.iter().map(|command| command.speed_estimate).collect()),
        effort_meas: None,
        field_meas_kv_mm: None,
        temperature_c: None,
        counts: None,
        extra: Vec::new(),
        ..recording.clone()
    })
}

/// Runs the machine along the motion, with the correction added to `commands`; positions as the sensor reports them at the
/// rows, late by its latency, before noise and rounding.
fn follow(
    model: &Model,
    recording: &Recording,
    path: Path<'_>,
    correction: &Correction,
    commands: &mut [Command],
) -> Result<Vec<f64>, plant::Error> {
    let (t_s, latency_s) = (&recording.t_s, model.sensor.latency_s);
    let rows = t_s.len();
    // The recorded position is late and errs with the angle, and so does where the motion is at a row.
    let wanted = |row: usize| {
        let (shown, speed) = (path.position[row], path.speed[row]);
        State::new(2.0 * shown - model.sensor.distorted(shown) + latency_s * speed, speed)
    };
    let first = wanted(0);
    let mut plant = Plant::new(model, first, t_s[0])?;
    let mut reported = Vec::with_capacity(rows);
    while reported.len() < rows && t_s[reported.len()] - latency_s <= t_s[0] {
        let before_s = t_s[reported.len()] - latency_s - t_s[0];
        reported.push(model.sensor.distorted(first.position + before_s * first.velocity));
    }
    for row in 0..rows {
        commands[row].torque = correction.command(commands[row].torque, wanted(row), plant.state());
        let last_s = (t_s[rows - 1] - latency_s).max(t_s[row]);
        let until_s = t_s.get(row + 1).copied().unwrap_or(last_s);
        if recording.gaps.binary_search(&row).is_ok() {
            // What was commanded in a gap is not known: the motion begins anew where the next sample is taken.
            let ahead_s = latency_s.max(0.0).min(until_s - t_s[row]);
            plant.advance(&commands[row], until_s - ahead_s)?;
            let behind = wanted(row + 1);
            plant.set_state(State::new(behind.position - ahead_s * behind.velocity, behind.velocity));
        }
        while reported.len() < rows && t_s[reported.len()] - latency_s <= until_s {
            plant.advance(&commands[row], (t_s[reported.len()] - latency_s).max(plant.now_s()))?;
            reported.push(plant.position_at_sensor());
        }
        plant.advance(&commands[row], until_s)?;
    }
    Ok(reported)
}
