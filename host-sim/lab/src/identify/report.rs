//! What was identified: as a machine file, as parameters of the drive, and in words.

use std::path::PathBuf;

use diagnosis::confidence_set::Interval;
use er_servo::{COUNTS_PER_REV, Config};

use super::Identified;
use super::steady::Steady;
use crate::read::{Axis, AxisKind, EffectEntry, ErNominal, Machine, PlantNominal};

/// How much of the field limit the wanted drag Q |w| of equation (5) takes at its peak, with the paper's fluid (control
/// specification, section 2: 3.2725 of 3.5 kV/mm).
const PEAK: f64 = 3.2725 / 3.5;

/// Field at the peak of the wanted drag, kV/mm.
pub(super) fn peak_field_kv_mm(before: &Config) -> f64 {
    PEAK * f64::from(before.field_limit_kv_mm)
}

/// The constant of (5) with which the wanted drag takes as much of the field limit at its peak as the paper's does of its own:
/// more than the fluid gives is no damping, less is wasted. The shape over the speed is a choice and no property of the machine.
/// Of coefficients without a peak the constant stays as it is.
pub(super) fn constant_of_5(before: &Config, steady: &Steady) -> Interval {
    let (q1, q2) = (f64::from(before.er_q1_s_rad), f64::from(before.er_q2_s2_rad2));
    // Q w = w exp(q2 w^2 + q1 w + q0) rises up to the smaller root of 2 q2 w^2 + q1 w + 1 = 0.
    let speed = 2.0 / ((q1 * q1 - 8.0 * q2).sqrt() - q1);
    let q0 = |torque: f64| (torque / speed).ln() - (q2 * speed + q1) * speed;
    let Interval { value, low, high } = steady.fluid_nm;
    let asked = Interval { value: q0(value), low: q0(low), high: q0(high) };
    let stays = f64::from(before.er_q0);
    let has_peak = speed.is_finite() && speed > 0.0;
    if has_peak && asked.low.is_finite() { asked } else { Interval { value: stays, low: stays, high: stays } }
}

/// The machine as far as torques at constant speed tell it, with an inertia and delays that count from the outputs; the field acts
/// at once.
pub(super) fn nominal(
    config: &Config,
    steady: &Steady,
    inertia: f64,
    torque_delay_s: f64,
    sample_to_output_s: f64,
) -> Machine {
    Machine {
        file: PathBuf::new(),
        name: "identified".to_owned(),
        axis: Axis {
            kind: AxisKind::Rotary,
            // The decimal number the single-precision one stands for.
            sample_period_s: (f64::from(config.period_s) * 1e9).round() * 1e-9,
            resolution: std::f64::consts::TAU / f64::from(COUNTS_PER_REV),
        },
        plant: PlantNominal {
            inertia,
            coulomb: steady.coulomb_nm.value.max(0.0),
            viscous: steady.viscous_nm_s_rad.value.max(0.0),
            torque_gain: 1.0,
            torque_offset: steady.offset_nm.value,
            torque_limit: None,
            sample_to_output_s,
            torque_delay_s,
            er: Some(ErNominal {
                a: steady.er_a.value.max(0.0),
                b: steady.er_b.value.max(0.0),
                dead_time_s: 0.0,
                lag_s: 0.0,
                fluid: None,
            }),
        },
        controller: None,
        columns: Default::default(),
        effects: Vec::new(),
    }
}

/// The machine file: what was found, and the law with what follows from it.
pub fn machine(before: &Config, found: &Identified) -> Machine {
    let (motion, field) = (&found.motion, &found.field);
    // What was found counts from the sample; the delays of the file count from the outputs.
    let to_output_s = found.sample_to_output_s;
    let from_output_s = |delay_s: f64| (delay_s - to_output_s).max(0.0);
    let torque_delay_s = from_output_s(motion.torque_delay_s.value);
    let mut machine = nominal(before, &found.steady, motion.inertia_kg_m2.value, torque_delay_s, to_output_s);
    if let Some(er) = &mut machine.plant.er {
        (er.dead_time_s, er.lag_s) = (from_output_s(field.dead_time_s.value), field.rise_s.value);
    }
    if field.is_asymmetric() {
        let parameters = [("rise_s", field.rise_s.value), ("fall_s", field.fall_s.value)];
        machine.effects.push(EffectEntry {
            id: "field_lag_asymmetry".to_owned(),
            recording: None,
            parameters: parameters.map(|(id, value)| (id.to_owned(), value)).to_vec(),
        });
    }
    machine.controller = Some(applied(before, found));
    machine
}

/// The parameters of the law with what was found of its machine; gains and limits are those before.
// Single precision is what the drive computes in.
#[allow(clippy::cast_possible_truncation)]
pub fn applied(before: &Config, found: &Identified) -> Config {
    let Identified { steady, er_q0, motion, field, .. } = found;
    let slower_s = field.rise_s.value.max(field.fall_s.value);
    Config {
        er_a: steady.er_a.value.max(1e-3) as f32,
        er_b: steady.er_b.value.max(0.0) as f32,
        er_c_nm: steady.coulomb_nm.value.max(0.0) as f32,
        er_q0: er_q0.value as f32,
        inertia_kg_m2: motion.inertia_kg_m2.value as f32,
        motor_delay_s: motion.torque_delay_s.value as f32,
        field_lag_s: (field.dead_time_s.value + slower_s).max(0.0005) as f32,
        ..*before
    }
}

/// For a person: each value with its 95 % interval.
pub fn text(found: &Identified) -> String {
    let Identified { steady, er_q0, motion, field, recordings, .. } = found;
    let row = |name: &str, unit: &str, of: &Interval, scale: f64| {
        let Interval { value, low, high } = of;
        format!("{name:<22} {:>10.5} {unit:<14} {:.5} to {:.5}\n", value * scale, low * scale, high * scale)
    };
    let mut text = String::new();
    text += &row("inertia", "kg m2", &motion.inertia_kg_m2, 1.0);
    text += &row("torque delay", "ms", &motion.torque_delay_s, 1e3);
    text += &row("c, dry friction", "N m", &steady.coulomb_nm, 1.0);
    text += &row("viscous friction", "N m s/rad", &steady.viscous_nm_s_rad, 1.0);
    text += &row("torque offset", "N m", &steady.offset_nm, 1.0);
    text += &row("a", "N m mm2/kV2", &steady.er_a, 1.0);
    text += &row("b", "N m mm/kV", &steady.er_b, 1.0);
    text += &row("constant of (5)", "ln(N m s/rad)", er_q0, 1.0);
    text += &row("field dead time", "ms", &field.dead_time_s, 1e3);
    if field.is_asymmetric() {
        text += &row("field rises in", "ms", &field.rise_s, 1e3);
        text += &row("field falls in", "ms", &field.fall_s, 1e3);
    } else {
        text += &row("field lag", "ms", &field.rise_s, 1e3);
    }
    text += "er_q1_s_rad and er_q2_s2_rad2 stay as they were: how (5) falls over the speed is chosen, not measured\n";
    let (passes, left, runs) = (steady.passes, steady.residual_nm * 1e3, recordings.len());
    text + &format!("{runs} experiments; {passes} passes at constant speed leave {left:.2} mN m\n")
}

/// A machine file with what was found as comments before it: the file itself has no place for intervals.
pub fn commented(found: &Identified, toml: &str) -> String {
    let lines: String = text(found).lines().map(|line| format!("# {line}\n")).collect();
    format!("# Found by experiments, with 95 % intervals:\n{lines}{toml}")
}
