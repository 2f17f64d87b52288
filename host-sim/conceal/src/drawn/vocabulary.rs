//! The vocabulary on any machine: which effects it can have, and what a size of each is.

use std::f64::consts::TAU;

use super::setting::{Law, Setting};
use crate::outside::{Scales, Shape};

/// Effects that act on the same number of the machine: no two of one row stand together.
const APART: [&[&str]; 4] = [
    &["field_lag", "field_lag_asymmetry", "viscosity_dead_time", "viscosity_lag"],
    &["viscosity_dead_time", "viscosity_lag", "field_dead_time", "field_slew_limit", "field_gain", "er_preyield"],
    &["compliance", "backlash"],
    &["viscosity_lag", "er_drift"],
];

/// Whether two effects can be in one machine.
pub(crate) fn together(one: &str, other: &str) -> bool {
    one != other && !APART.iter().any(|row| row.contains(&one) && row.contains(&other))
}

/// Whether a machine can have an effect, and its log can show it.
pub(crate) fn possible(id: &str, setting: &Setting, scales: &Scales) -> bool {
    let of_fluid = id.starts_with("field_") || id.starts_with("er_");
    match id {
        _ if of_fluid => setting.has_fluid() && scales.field_kv_mm > 0.2,
        // The delayed coefficient is that of the flashed law.
        "viscosity_dead_time" | "viscosity_lag" => matches!(setting.law, Law::Servo(_)),
        "gravity_load" => !setting.linear && scales.travel > 0.5,
        "resolver_eccentricity" => !setting.linear && scales.travel > 0.4,
        "presliding" | "friction_asymmetry" => scales.coulomb > 0.02 * scales.torque,
        // A torque that was measured shows nothing of what is before it.
        "torque_delay" | "torque_lag" | "torque_saturation" | "torque_deadband" | "torque_gain" | "torque_offset"
        | "torque_ripple" => setting.measured.is_none(),
        "temperature_viscosity" => setting.physics.friction.viscous_nm_s_rad * scales.speed > 0.05 * scales.torque,
        _ => true,
    }
}

fn sign(shape: &Shape) -> f64 {
    if shape[0] < 0.5 { 1.0 } else { -1.0 }
}

fn pick(values: &[f64], share: f64) -> f64 {
    values[((share * values.len() as f64) as usize).min(values.len() - 1)]
}

/// Order and phase of a wave over the position.
fn wave_over_angle(setting: &Setting, c: &Scales, u: &Shape) -> [f64; 2] {
    let least = 3.0 / c.travel;
    // No faster than a tenth of the rows at the usual speed.
    let most = (0.1 * TAU / (c.period_s * c.speed)).clamp(2.0 * least, 60.0_f64.max(3.0 * least));
    let order = least * (most / least).powf(u[2]);
    [if setting.linear { order } else { order.round() }, TAU * (u[1] - 0.5)]
}

/// Values of an effect, in the order of the catalogue's parameters, at a size from 0, none, to 1, as large as the torques of the
/// motion; none where there is no such size.
// Over 40 lines: one line for each effect.
pub(crate) fn values(id: &str, setting: &Setting, c: &Scales, size: f64, u: &Shape) -> Option<Vec<f64>> {
    let physics = &setting.physics;
    let fluid = &physics.fluid;
    let (torque, angle) = (size * c.torque, TAU * (u[1] - 0.5));
    let top_hz = (0.15 / c.period_s).min(60.0);
    let both = |value: f64| sign(u) * value;
    let above = |value: f64, least: f64| (value > least).then_some(value);
    Some(match id {
        "field_dead_time" => vec![fluid.dead_time_s + 0.02 * size],
        "field_lag" => vec![fluid.rise_s + 0.02 * size],
        "field_lag_asymmetry" => vec![fluid.rise_s, fluid.fall_s + 0.04 * size],
        "field_slew_limit" => vec![50.0 / size],
        "field_gain" | "er_strength" => vec![above(1.0 + both(size), 0.2)?],
        "er_drift" => vec![above(both(size) / c.duration_s, -0.8 / c.duration_s)?],
        "er_preyield" => vec![c.torque / (0.1 * c.travel * size)],
        "viscosity_dead_time" | "viscosity_lag" => vec![0.02 * size],
        "coulomb_friction" => vec![above(c.coulomb + both(torque), 0.1 * c.coulomb).unwrap_or(c.coulomb + torque)],
        "viscous_friction" => vec![physics.friction.viscous_nm_s_rad + torque / c.speed],
        "stribeck_friction" => vec![torque, c.speed * (0.03 + 0.2 * u[1])],
        "friction_asymmetry" => {
            vec![both(above(2.0 * torque, 0.0).filter(|difference| *difference < 1.8 * c.coulomb)?), 0.0]
        }
        "presliding" => vec![c.coulomb / (0.1 * c.travel * size)],
        "torque_gain" => vec![above(1.0 + both(size), 0.2)?],
        "torque_offset" => vec![both(torque)],
        // The scale is a root mean square: peaks are about three times that.
        "torque_saturation" => vec![above(3.0 * c.torque * (1.0 - size), 0.5 * c.torque + c.coulomb)?],
        "torque_deadband" => vec![torque],
        "torque_delay" => vec![physics.drive.delay_s + 0.02 * size],
        "torque_lag" => vec![0.02 * size],
        "cogging" => {
            let [order, phase] = wave_over_angle(setting, c, u);
            vec![torque, order, phase]
        }
        "torque_ripple" => {
            let [order, phase] = wave_over_angle(setting, c, u);
            vec![(size < 0.9).then_some(size)?, order, phase]
        }
        "load_dependent_friction" => vec![0.9 * size],
        // At 1 the work of a recording leaves a hundredth of the friction; it cools away in half to twice as long.
        "temperature_viscosity" => {
            let work_j = c.torque * c.speed * c.duration_s;
            vec![5.0 * size / work_j, 1.0 / (c.duration_s * (0.5 + 1.5 * u[1]))]
        }
        "inertia" => vec![above(physics.inertia_kg_m2 * (1.0 + both(size)), 0.3 * physics.inertia_kg_m2)?],
        "gravity_load" => vec![torque, angle],
        "spring_load" => vec![torque / c.travel],
        "compliance" => vec![top_hz / (10.0 * size).sqrt(), 0.02 + 0.08 * u[1], 0.2 + 0.8 * u[2]],
        "backlash" => vec![0.1 * c.travel * size, top_hz * (0.5 + 0.5 * u[1]), 0.02 + 0.08 * u[2], 0.2 + 0.6 * u[3]],
        "disturbance_pulse" => {
            let length_s = c.duration_s * (0.01 + 0.03 * u[1]);
            vec![c.duration_s * (0.1 + 0.7 * u[2]), length_s, both(4.0 * torque)]
        }
        "vibration" => vec![5.0 + (top_hz.min(40.0) - 5.0).max(1.0) * u[1], torque],
        "quadratic_drag" => vec![torque / c.speed.powi(2)],
        "resolver_eccentricity" => {
            vec![0.02 * size * c.travel, pick(&[1.0, 2.0, 4.0, 8.0], u[2]).max((1.5 / c.travel).ceil()), angle]
        }
        "sensor_latency" => vec![0.02 * size],
        "sensor_glitch" => vec![0.003, 0.1 * size * c.travel],
        _ => return None,
    })
}
