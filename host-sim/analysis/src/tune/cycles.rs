//! Limit cycles of the nonlinear loop under tuned gains, by harmonic balance: what the linear loop cannot say of the
//! viscosities above those its margins are kept for.

use er_servo::Config;
use plant::{FluidResponse, Model};
use rayon::prelude::*;

use super::Task;
use super::trial::{config_for, delayed};
use crate::stability::Gains;
use crate::stability::describing::{Damper, DamperDelay, NonlinearLoop, Search};
use recording::Error;

/// Limit cycles over the nominal delays, and all of them off by the uncertainty either way.
///
/// # Errors
/// Parameters the law does not take.
pub fn limit_cycles(task: &Task, gains: Gains) -> Result<usize, Error> {
    let config = config_for(&task.config, gains, &task.model, task.uncertainty);
    let factors = [1.0, 1.0 + task.uncertainty, 1.0 - task.uncertainty];
    let counts = factors.into_par_iter().map(|factor| count(&delayed(&task.model, factor), &config, gains));
    Ok(counts.collect::<Result<Vec<_>, _>>()?.iter().sum())
}

fn count(model: &Model, config: &Config, gains: Gains) -> Result<usize, Error> {
    // The hold delays torque and field by half a period.
    let hold_s = 0.5 * f64::from(config.period_s);
    let damped = model.er.as_ref().filter(|_| config.er_enabled);
    let damper = damped.map(|er| Damper::new(config, delay(er.response, hold_s))).transpose();
    let damper = damper.map_err(|error| Error::Usage(format!("[controller] {error}")))?;
    let closed = NonlinearLoop {
        inertia_kg_m2: model.inertia,
        torque_delay_s: model.torque_delay_s + hold_s,
        coulomb_nm: model.coulomb,
        gains,
        torque_limit_nm: f64::from(config.torque_limit_nm),
        damper: damper.as_ref(),
    };
    Ok(closed.limit_cycles(Search::SERVO).len())
}

fn delay(response: FluidResponse, hold_s: f64) -> DamperDelay {
    match response {
        FluidResponse::Field(field) => {
            DamperDelay::Field { dead_time_s: field.dead_time_s, lag_s: field.rise_s.max(field.fall_s) }
        }
        FluidResponse::ViscosityDeadTime { dead_time_s, torque_limit } => {
            DamperDelay::Viscosity { dead_time_s, lag_s: 0.0, bounded: torque_limit.is_finite() }
        }
        FluidResponse::ViscosityLag { lag_s, torque_limit } => {
            DamperDelay::Viscosity { dead_time_s: 0.0, lag_s, bounded: torque_limit.is_finite() }
        }
    }
    .later_by(hold_s)
}
