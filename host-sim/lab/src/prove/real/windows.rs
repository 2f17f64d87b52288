//! Windows of a recording under any model, simulated by the examiner's own physics: neither the plant's nor the tool's.

use conceal::named::put_named;
use conceal::physics::{Physics, Wave};
use conceal::rotor::{Command, Rotor};
use nalgebra::{Matrix2, Vector2};

use crate::read::{Machine, Recording};

/// Lengths of the windows, s (diagnosis.md).
pub(crate) const HORIZONS_S: [f64; 2] = [0.05, 0.2];
/// How long a model is led along the recording before a window, so that its drive and fluid know what was commanded, s.
const LED_S: f64 = 0.06;
/// Longest step, s.
const STEP_S: f64 = 5e-5;
/// Rounds in which the start of a window is put where it leaves least.
const ROUNDS: usize = 2;
/// What is slower than this is a local slope, s.
const SLOPE_S: f64 = 0.01;

/// A model as the examiner's physics has it.
#[derive(Debug, Clone)]
pub(crate) struct Simulated {
    physics: Physics,
    /// The position is reported late by this, s; negative where commands are.
    latency_s: f64,
    /// Errors of the sensor over the angle.
    eccentricity: Vec<Wave>,
}

impl Simulated {
    /// Of a machine file. Events of single recordings and vibrations, whose phase is free, are in no other recording.
    pub(crate) fn of(machine: &Machine) -> Self {
        let plant = &machine.plant;
        let mut physics = Physics::nominal();
        physics.inertia_kg_m2 = plant.inertia;
        (physics.friction.coulomb_nm, physics.friction.viscous_nm_s_rad) = (plant.coulomb, plant.viscous);
        (physics.drive.gain, physics.drive.offset_nm) = (plant.torque_gain, plant.torque_offset);
        physics.drive.limit_nm = plant.torque_limit.unwrap_or(f64::INFINITY);
        physics.drive.delay_s = plant.torque_delay_from_sample_s();
        let fluid = &mut physics.fluid;
        (fluid.a, fluid.b) = plant.er.as_ref().map_or((0.0, 0.0), |er| (er.a, er.b));
        if let Some(er) = &plant.er {
            let dead_time_s = plant.sample_to_output_s + er.dead_time_s;
            (fluid.dead_time_s, fluid.rise_s, fluid.fall_s) = (dead_time_s, er.lag_s, er.lag_s);
        }
        let mut simulated = Self { physics, latency_s: 0.0, eccentricity: Vec::new() };
        for entry in machine.effects.iter().filter(|entry| entry.recording.is_none()) {
            match entry.id.as_str() {
                "vibration" | "disturbance_pulse" | "sensor_glitch" => (),
                "sensor_latency" => simulated.latency_s = entry.parameters.first().map_or(0.0, |(_, value)| *value),
                "resolver_eccentricity" => {
                    put_named(&entry.id, &entry.parameters, &mut simulated.physics);
                    simulated.eccentricity.extend(simulated.physics.sensor.eccentricity.take());
                }
                _ => {
                    put_named(&entry.id, &entry.parameters, &mut simulated.physics);
                }
            }
        }
        simulated
    }

    /// Root mean square of what windows of a length leave, in the unit of the position; none where no window fits.
    pub(crate) fn left(&self, recording: &Recording, horizon_s: f64) -> Option<f64> {
        let period_s = period_s(recording);
        let rows = ((horizon_s / period_s).round() as usize).max(4);
        let led = (LED_S / period_s).ceil() as usize;
        let gap = |from: usize, to: usize| recording.gaps.iter().any(|at| (from..to).contains(at));
        let starts = (led..recording.rows().saturating_sub(rows + 1)).step_by(rows);
        let squares: Vec<f64> = starts
            .filter(|&start| !gap(start - led, start + rows))
            .map(|start| self.window(recording, start, rows, led))
            .filter(|square| square.is_finite())
            .collect();
        (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / (squares.len() * rows) as f64).sqrt())
    }

    /// Squares of what a window leaves about its best straight line.
    fn window(&self, recording: &Recording, start: usize, rows: usize, led: usize) -> f64 {
        let mut at = [recording.position[start], slope(recording, start)];
        let mut squares = f64::INFINITY;
        for _ in 0..=ROUNDS {
            let path = self.path(recording, start, rows, led, at);
            let left: Vec<f64> = (0..rows).map(|k| recording.position[start + k] - path[k]).collect();
            let time = |k: usize| recording.t_s[start + k] - recording.t_s[start];
            let Some([offset, speed]) = line(&left, time) else { return f64::INFINITY };
            squares = left.iter().enumerate().map(|(k, left)| (left - offset - speed * time(k)).powi(2)).sum();
            at = [at[0] + offset, at[1] + speed];
        }
        squares
    }

    /// Positions as the sensor would have them at the rows of a window.
    fn path(&self, recording: &Recording, start: usize, rows: usize, led: usize, at: [f64; 2]) -> Vec<f64> {
        let period_s = period_s(recording);
        let whole = (period_s / STEP_S).ceil();
        let mut rotor = Rotor::new(&self.physics, period_s / whole);
        let play = |rotor: &mut Rotor, row: usize| {
            let length_s = recording.t_s[row + 1] - recording.t_s[row];
            let field = recording.field_cmd_kv_mm.as_ref().map_or(0.0, |field| field[row]);
            let command = Command { torque_nm: recording.effort_cmd[row], field_kv_mm: field, ..Command::default() };
            (0..(length_s / period_s * whole).round().max(1.0) as usize).for_each(|_| rotor.step(&command));
        };
        for row in start - led..start {
            rotor.place(recording.position[row], slope(recording, row));
            play(&mut rotor, row);
        }
        rotor.place(at[0], at[1]);
        let mut truth = Vec::with_capacity(rows);
        for row in start..start + rows {
            truth.push((rotor.position_rad(), rotor.speed_rad_s()));
            play(&mut rotor, row);
        }
        let shown = |(position, speed): &(f64, f64)| {
            // Within a row or two the speed carries the position on.
            let late = position - speed * self.latency_s;
            late + self.eccentricity.iter().map(|wave| wave.at(late)).sum::<f64>()
        };
        truth.iter().map(shown).collect()
    }
}

/// Mean period, s.
pub(crate) fn period_s(recording: &Recording) -> f64 {
    let rows = recording.rows();
    (recording.t_s[rows - 1] - recording.t_s[0]) / (rows - 1).max(1) as f64
}

/// Speed at a row: the slope of the readings around it.
pub(crate) fn slope(recording: &Recording, row: usize) -> f64 {
    let around = ((SLOPE_S / period_s(recording)).round() as usize).max(2);
    let (from, to) = (row.saturating_sub(around), (row + around).min(recording.rows() - 1));
    let middle = recording.t_s[row];
    line(&recording.position[from..=to], |k| recording.t_s[from + k] - middle).map_or(0.0, |[_, slope]| slope)
}

/// Offset and slope of the best straight line.
fn line(values: &[f64], time: impl Fn(usize) -> f64) -> Option<[f64; 2]> {
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for (k, value) in values.iter().enumerate() {
        let row = Vector2::new(1.0, time(k));
        normal += row * row.transpose();
        right += row * *value;
    }
    normal.try_inverse().map(|inverse| (inverse * right).into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual::testing::{same_delays, swinging};

    #[test]
    fn torque_and_field_act_after_the_time_to_the_output_and_their_delays() {
        let recording = swinging();
        let [one, other] = same_delays().map(|machine| Simulated::of(&machine));
        assert_eq!((one.physics.drive.delay_s, one.physics.fluid.dead_time_s), (0.005, 0.002));
        let left = one.left(&recording, 0.05);
        assert!(left.is_some_and(|left| left > 0.0), "{left:?}");
        assert_eq!(left, other.left(&recording, 0.05));
    }
}
