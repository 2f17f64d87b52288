//! What gains do in the nonlinear loop: the flashed law on the plant, small and large steps, nominal and off.

use er_servo::{Config, Counts, Params, RAD_PER_COUNT};
use plant::{FieldResponse, FluidResponse, Model};

use crate::beyond::{self, Mode};
use crate::simulate::{Disturbance, Row, Setup, Summary, run};
use crate::stability::Gains;
use recording::Error;

/// What is tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steps {
    /// Large step, rad.
    pub large_rad: f64,
    /// Small step, rad.
    pub small_rad: f64,
    /// Settled within this, or 2 % of the step where that is more, rad.
    pub tolerance_rad: f64,
    /// Largest overshoot, share of the step.
    pub overshoot: f64,
}

/// Figures of gains that do what is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// Settling of the large and of the small step with the nominal delays, s.
    pub settling_s: [f64; 2],
    /// The worse overshoot over both steps and all delays tried, share of the step.
    pub overshoot: f64,
    /// Largest distance from rest under 8 N m for 50 ms, rad.
    pub push_rad: f64,
}

impl Trial {
    /// What is minimised: the mean of both settling times, s.
    #[must_use]
    pub fn cost_s(&self) -> f64 {
        0.5 * (self.settling_s[0] + self.settling_s[1])
    }
}

/// The parameters of the law with other gains, and with what must follow the gains.
///
/// The brake's zone stays, or becomes 1.25 times the error the brake can hold. The low-pass of the speed stays at or
/// under 0.4 L (control.md section 3). The rotor is not called stuck before the motor has had time to answer.
#[must_use]
pub fn config_for(config: &Config, gains: Gains, model: &Model, uncertainty: f64) -> Config {
    let (kp_nm_rad, kd_nm_s_rad) = (gains.k_p_nm_rad as f32, gains.k_d_nm_s_rad as f32);
    let field = config.brake_field_kv_mm;
    let held_rad = (config.er_c_nm + (config.er_a * field + config.er_b) * field) / kp_nm_rad;
    let slowest_s = (model.torque_delay_s * (1.0 + uncertainty)) as f32;
    Config {
        kp_nm_rad,
        kd_nm_s_rad,
        near_rad: if config.near_rad > 0.0 { config.near_rad.max(1.25 * held_rad) } else { 0.0 },
        speed_filter_s: config.speed_filter_s.min(0.4 * model.torque_delay_s as f32),
        stale_time_s: config.stale_time_s.max(4.0 * slowest_s).min(1.0),
        ..*config
    }
}

/// The model with every delay times a factor.
pub(super) fn delayed(model: &Model, factor: f64) -> Model {
    let mut model = model.clone();
    model.torque_delay_s *= factor;
    if let Some(er) = &mut model.er {
        er.response = match er.response {
            FluidResponse::Field(field) => FluidResponse::Field(FieldResponse {
                dead_time_s: field.dead_time_s * factor,
                rise_s: field.rise_s * factor,
                fall_s: field.fall_s * factor,
                ..field
            }),
            FluidResponse::ViscosityDeadTime { dead_time_s, torque_limit } => {
                FluidResponse::ViscosityDeadTime { dead_time_s: dead_time_s * factor, torque_limit }
            }
            FluidResponse::ViscosityLag { lag_s, torque_limit } => {
                FluidResponse::ViscosityLag { lag_s: lag_s * factor, torque_limit }
            }
        };
    }
    model
}

/// The flashed law, or a mode in its place.
fn rows(mode: Option<&Mode>, setup: &Setup, reference: Counts, duration_s: f64) -> Result<Vec<Row>, Error> {
    let ticks = (duration_s / f64::from(setup.config.period_s)) as usize;
    let reference = std::iter::repeat_n(reference, ticks);
    match mode {
        None => run(setup, reference),
        Some(mode) => beyond::run(mode, setup, reference),
    }
}

/// One step: settling, s, and overshoot; none if it does not settle or the drive trips.
fn step(mode: Option<&Mode>, setup: &Setup, step_rad: f64, steps: &Steps) -> Result<Option<(f64, f64)>, Error> {
    let period_s = f64::from(setup.config.period_s);
    let duration_s = (0.3 + 100.0 * setup.model.torque_delay_s).min(3.0);
    let rows = rows(mode, setup, Counts::from_rad(step_rad), duration_s)?;
    let summary = Summary::of(&rows, period_s);
    let band_rad = steps.tolerance_rad.max(0.02 * step_rad);
    let last = rows.iter().rposition(|row| (step_rad - row.truth.position).abs() > band_rad);
    let Some((step_figures, last)) = summary.step.zip(last) else { return Ok(None) };
    if summary.faulted || last + 1 == rows.len() {
        return Ok(None);
    }
    // The moment between two ticks: a settling time in whole ticks would have no slope to follow.
    let off = |index: usize| rows.get(index).map_or(band_rad, |row| (step_rad - row.truth.position).abs());
    let share = (off(last) - band_rad) / (off(last) - off(last + 1)).max(f64::from(RAD_PER_COUNT) * 1e-6);
    Ok(Some(((last as f64 + share.clamp(0.0, 1.0)) * period_s, step_figures.overshoot)))
}

/// Tries gains; none if the law refuses them, a step does not settle, or one overshoots more than allowed with the
/// nominal delays or with all of them off by the uncertainty, either way.
///
/// # Errors
/// A model the plant does not take.
pub fn trial(model: &Model, config: &Config, uncertainty: f64, steps: &Steps) -> Result<Option<Trial>, Error> {
    trial_of(None, model, config, uncertainty, steps)
}

/// The same of a mode beside the law, whose gains are those of `config` times the mode's factor.
///
/// # Errors
/// As [`trial`].
pub(super) fn trial_of(
    mode: Option<&Mode>,
    model: &Model,
    config: &Config,
    uncertainty: f64,
    steps: &Steps,
) -> Result<Option<Trial>, Error> {
    if Params::new(config).is_err() {
        return Ok(None);
    }
    let mut settling_s = [0.0; 2];
    let mut overshoot: f64 = 0.0;
    for factor in [1.0, 1.0 + uncertainty, 1.0 - uncertainty] {
        let setup = setup(delayed(model, factor), config, Vec::new());
        for (settling_s, step_rad) in settling_s.iter_mut().zip([steps.large_rad, steps.small_rad]) {
            let Some((settled_s, over)) = step(mode, &setup, step_rad, steps)? else { return Ok(None) };
            overshoot = overshoot.max(over);
            if overshoot > steps.overshoot {
                return Ok(None);
            }
            if factor == 1.0 {
                *settling_s = settled_s;
            }
        }
    }
    Ok(Some(Trial { settling_s, overshoot, push_rad: push_rad(mode, model, config)? }))
}

/// The push of control.md section 7.
fn push_rad(mode: Option<&Mode>, model: &Model, config: &Config) -> Result<f64, Error> {
    let push = Disturbance { start_s: 0.0, duration_s: 0.05, torque_nm: 8.0 };
    let rows = rows(mode, &setup(model.clone(), config, vec![push]), Counts(0), 0.2)?;
    Ok(rows.iter().map(|row| row.truth.position.abs()).fold(0.0, f64::max))
}

fn setup(model: Model, config: &Config, disturbances: Vec<Disturbance>) -> Setup {
    Setup { model, config: *config, disturbances, sensor_noise_rad: 0.0, torque_noise_nm: 0.0, seed: 0 }
}
