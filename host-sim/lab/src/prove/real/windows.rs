//! Windows of a recording under any model, simulated by the examiner's own physics: neither the plant's nor the tool's.

use std::collections::BTreeSet;
use std::ops::Range;

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
    /// The torque acts later than its column says by this, s; negative where it acts earlier.
    skew_s: f64,
    /// The torque column is behind a first-order filter of this time constant, s.
    filter_s: f64,
    /// Effects of the file that are not simulated.
    without: BTreeSet<String>,
}

/// Effects that no window can have: a phase that is free in each recording, and what depends on the time or the work before it.
const BEYOND_WINDOWS: [&str; 3] = ["vibration", "er_drift", "temperature_viscosity"];

impl Simulated {
    /// Of a machine file. Events of single recordings are in no other recording, and wrong samples none of the motion.
    pub(crate) fn of(machine: &Machine) -> Self {
        let mut simulated = Self {
            physics: plant(machine),
            latency_s: 0.0,
            eccentricity: Vec::new(),
            skew_s: 0.0,
            filter_s: 0.0,
            without: BTreeSet::new(),
        };
        for entry in machine.effects.iter().filter(|entry| entry.recording.is_none() && entry.id != "sensor_glitch") {
            if !simulated.put(&entry.id, &entry.parameters) {
                simulated.without.insert(entry.id.clone());
            }
        }
        simulated
    }

    /// Whether this is simulated now.
    fn put(&mut self, id: &str, parameters: &[(String, f64)]) -> bool {
        let own = match id {
            _ if BEYOND_WINDOWS.contains(&id) => return false,
            "sensor_latency" => &mut self.latency_s,
            "channel_skew" => &mut self.skew_s,
            "torque_filter" => &mut self.filter_s,
            _ => {
                let is_put = put_named(id, parameters, &mut self.physics);
                self.eccentricity.extend(self.physics.sensor.eccentricity.take());
                return is_put;
            }
        };
        let Some((_, value)) = parameters.first() else { return false };
        *own = *value;
        true
    }

    /// Effects of the file that are left out of the simulation.
    pub(crate) fn without(&self) -> &BTreeSet<String> {
        &self.without
    }

    /// Root mean square of what windows of a length leave, in the unit of the position; none where no window fits.
    pub(crate) fn left(&self, recording: &Recording, horizon_s: f64) -> Option<f64> {
        let period_s = period_s(recording);
        let rows = ((horizon_s / period_s).round() as usize).max(4);
        let led = (LED_S / period_s).ceil() as usize;
        let torque = self.torque(recording);
        let gap = |from: usize, to: usize| recording.gaps.iter().any(|at| (from..to).contains(at));
        let starts = (led..recording.rows().saturating_sub(rows + 1)).step_by(rows);
        let squares: Vec<f64> = starts
            .filter(|&start| !gap(start - led, start + rows))
            .map(|start| self.window(recording, &torque, start, rows, led))
            .filter(|square| square.is_finite())
            .collect();
        (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / (squares.len() * rows) as f64).sqrt())
    }

    /// Torque that acts on the drive's input, row by row: what the filter was given, so much later.
    fn torque(&self, recording: &Recording) -> Vec<f64> {
        let (column, t_s) = (&recording.effort_cmd, &recording.t_s);
        let last = column.len() - 1;
        // tau dT_m/dt = T - T_m.
        let given = |row: usize| {
            let (from, to) = (row.saturating_sub(1), (row + 1).min(last));
            column[row] + self.filter_s * (column[to] - column[from]) / (t_s[to] - t_s[from])
        };
        let given: Vec<f64> = if self.filter_s > 0.0 { (0..=last).map(given).collect() } else { column.clone() };
        let late = self.skew_s / period_s(recording);
        let at = |row: f64| given[row.clamp(0.0, last as f64) as usize];
        // Held from row to row: the mean over a row is of two.
        let mean = |row: usize| {
            let (whole, part) = ((row as f64 - late).floor(), (row as f64 - late).rem_euclid(1.0));
            at(whole) + part * (at(whole + 1.0) - at(whole))
        };
        (0..=last).map(mean).collect()
    }

    /// Squares of what a window leaves about its best straight line.
    fn window(&self, recording: &Recording, torque: &[f64], start: usize, rows: usize, led: usize) -> f64 {
        let mut at = [recording.position[start], slope(recording, start)];
        let mut squares = f64::INFINITY;
        for _ in 0..=ROUNDS {
            let path = self.path(recording, torque, start..start + rows, led, at);
            let left: Vec<f64> = (0..rows).map(|k| recording.position[start + k] - path[k]).collect();
            let time = |k: usize| recording.t_s[start + k] - recording.t_s[start];
            let Some([offset, speed]) = line(&left, time) else { return f64::INFINITY };
            squares = left.iter().enumerate().map(|(k, left)| (left - offset - speed * time(k)).powi(2)).sum();
            at = [at[0] + offset, at[1] + speed];
        }
        squares
    }

    /// Positions as the sensor would have them at the rows of a window.
    fn path(&self, recording: &Recording, torque: &[f64], rows: Range<usize>, led: usize, at: [f64; 2]) -> Vec<f64> {
        let period_s = period_s(recording);
        let whole = (period_s / STEP_S).ceil();
        let mut rotor = Rotor::new(&self.physics, period_s / whole);
        let play = |rotor: &mut Rotor, row: usize| {
            let length_s = recording.t_s[row + 1] - recording.t_s[row];
            let field = recording.field_cmd_kv_mm.as_ref().map_or(0.0, |field| field[row]);
            let command = Command { torque_nm: torque[row], field_kv_mm: field, ..Command::default() };
            (0..(length_s / period_s * whole).round().max(1.0) as usize).for_each(|_| rotor.step(&command));
        };
        for row in rows.start - led..rows.start {
            rotor.place(recording.position[row], slope(recording, row));
            play(&mut rotor, row);
        }
        rotor.place(at[0], at[1]);
        let mut truth = Vec::with_capacity(rows.len());
        for row in rows {
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

/// The plant of a machine file, without its effects.
fn plant(machine: &Machine) -> Physics {
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
    physics
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
    #![allow(clippy::unwrap_used)]
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

    fn with(effects: &str) -> Simulated {
        let text = format!(
            "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 0.001\nresolution = 0.0\n[plant]\ninertia = 0.1\n\
             {effects}"
        );
        Simulated::of(&Machine::from_bytes(std::path::Path::new("m.toml"), text.as_bytes()).unwrap())
    }

    #[test]
    fn a_skewed_or_filtered_column_is_undone_and_what_no_window_has_is_told() {
        let mut recording = Recording::empty(crate::read::AxisKind::Rotary);
        for row in 0..6 {
            let row = f64::from(row);
            recording.t_s.push(1e-3 * row);
            recording.position.push(0.0);
            recording.effort_cmd.push(10.0 * row);
        }
        let skewed = with("[[effects]]\nid = \"channel_skew\"\nskew_s = 0.00125\n").torque(&recording);
        assert!((skewed[3] - 17.5).abs() < 1e-9 && (skewed[5] - 37.5).abs() < 1e-9, "{skewed:?}");
        let early = with("[[effects]]\nid = \"channel_skew\"\nskew_s = -0.002\n").torque(&recording);
        assert!((early[1] - 30.0).abs() < 1e-9 && early[5] == 50.0, "{early:?}");
        // 10 N m each row behind 3 rows of filter.
        let filtered = with("[[effects]]\nid = \"torque_filter\"\nlag_s = 0.003\n").torque(&recording);
        assert!((filtered[2] - 50.0).abs() < 1e-9, "{filtered:?}");
        let all = with(
            "[[effects]]\nid = \"vibration\"\nfrequency_hz = 5.0\namplitude_nm = 1.0\n\
             [[effects]]\nid = \"load_dependent_friction\"\ncoefficient = 0.1\n\
             [[effects]]\nid = \"torque_ripple\"\ngain_amplitude = 0.1\norder_per_rev = 3.0\nphase_rad = 0.0\n",
        );
        assert_eq!(all.without().iter().collect::<Vec<_>>(), ["vibration"]);
        assert_eq!((all.physics.friction.per_load, all.physics.drive.ripple.len()), (0.1, 1));
    }
}
