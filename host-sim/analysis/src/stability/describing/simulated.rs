//! The same loop in time: the flashed law on the plant, run until only a limit cycle is left.

use er_servo::{Config, Counts};
use plant::{Er, FieldResponse, FluidResponse, Model};

use super::DamperDelay;
use crate::simulate::{Setup, run};
use crate::stability::case::Loop;
use recording::Error;

/// The step a run begins with, rad. Rest is always one of the ends, as friction holds, and a lasting cycle another: which
/// one a run falls into depends on how it begins. From 30 degrees the loop with Q 50 ms late happens to come to rest;
/// from here it falls into the cycle that harmonic balance finds.
const STEP_RAD: f64 = 0.1;
/// Length of a run, s; swings near a limit cycle approach it within some tens of periods.
const RUN_S: f64 = 2.0;

/// Amplitude of the angle that is left over the last fifth of a run after a step, rad: half from peak to peak, about 0
/// where the rotor has come to rest. The speed is the true one without a filter, as in the harmonic balance.
///
/// # Errors
/// A law or a plant that does not take these values.
pub fn remaining_amplitude_rad(
    closed: &Loop,
    config: &Config,
    coulomb_nm: f64,
    delay: Option<DamperDelay>,
) -> Result<f64, Error> {
    let config = Config { speed_from_converter: true, speed_filter_s: 0.0, er_enabled: delay.is_some(), ..*config };
    let (a, b) = (f64::from(config.er_a), f64::from(config.er_b));
    let model = Model {
        coulomb: coulomb_nm,
        torque_delay_s: closed.plant().torque_delay_s,
        torque_limit: Some(f64::from(config.torque_limit_nm)),
        er: delay.map(|delay| Er { response: response(delay, Er::largest_torque(a, b)), ..Er::new(a, b, 0.0, 0.0) }),
        ..Model::new(closed.plant().inertia_kg_m2)
    };
    let setup = Setup { model, config, disturbances: Vec::new(), sensor_noise_rad: 0.0, torque_noise_nm: 0.0, seed: 0 };
    let ticks = (RUN_S / f64::from(config.period_s)) as usize;
    let rows = run(&setup, std::iter::repeat_n(Counts::from_rad(STEP_RAD), ticks))?;
    let late = rows[ticks - ticks / 5..].iter().map(|row| row.truth.position);
    let (low, high) = late.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    Ok(0.5 * (high - low))
}

/// The plant's name for a delay model; `most_nm` is what the fluid can give at the highest field, N m.
fn response(delay: DamperDelay, most_nm: f64) -> FluidResponse {
    match delay {
        DamperDelay::Field { dead_time_s, lag_s } => FluidResponse::Field(FieldResponse::new(dead_time_s, lag_s)),
        DamperDelay::Viscosity { dead_time_s, lag_s, bounded } => {
            let torque_limit = if bounded { most_nm } else { f64::INFINITY };
            if lag_s == 0.0 {
                FluidResponse::ViscosityDeadTime { dead_time_s, torque_limit }
            } else {
                FluidResponse::ViscosityLag { lag_s, torque_limit }
            }
        }
    }
}
