//! Residual torque and candidate columns of recordings.

use super::smooth::{HALF, Kernels};
use crate::read::{Machine, Recording};

/// Slower than this the sign of the speed is noise, and the axis may stand, rad/s or m/s.
const MOVING: f64 = 0.03;
/// One row in this many is used.
const STRIDE: usize = 5;
/// Orders a revolution that are tried.
const ORDERS: [f64; 9] = [2.0, 6.0, 7.0, 12.0, 14.0, 24.0, 28.0, 36.0, 48.0];
/// Speeds of the Stribeck curve that are tried.
const STRIBECK: [f64; 3] = [0.05, 0.1, 0.2];
/// Further delays that are tried, s.
const DELAYS_S: [f64; 4] = [0.001, 0.002, 0.004, 0.008];

/// Columns that stand for one effect with one value of what is not linear in it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Group {
    pub(super) id: &'static str,
    /// Columns, from the first to before the last.
    pub(super) columns: std::ops::Range<usize>,
}

/// Rows of residual torque with their columns.
#[derive(Debug, Clone, Default)]
pub(super) struct Table {
    pub(super) groups: Vec<Group>,
    pub(super) residual: Vec<f64>,
    /// Row by row.
    pub(super) rows: Vec<Vec<f64>>,
}

/// A recording's signals on its own grid of samples, taken as even.
struct Signals<'a> {
    kernels: Kernels,
    period_s: f64,
    position: &'a [f64],
    torque: Vec<f64>,
    er: Vec<f64>,
    er_slope: Vec<f64>,
    er_delayed: Vec<[f64; 2]>,
    acting: Vec<f64>,
}

impl Table {
    /// Adds the rows of a recording: where it moves, away from gaps.
    pub(super) fn add(&mut self, machine: &Machine, recording: &Recording) {
        let rows = recording.rows();
        let Some(kernels) = Kernels::new().filter(|_| rows > 4 * HALF) else { return };
        let span_s = recording.t_s[rows - 1] - recording.t_s[0];
        let lost: usize = recording.seq.as_ref().map_or(0, |seq| (seq[rows - 1] - seq[0]) as usize + 1 - rows);
        let signals = Signals::new(machine, recording, kernels, span_s / (rows - 1 + lost) as f64);
        let near_gap = |at: usize| recording.gaps.iter().any(|gap| gap.abs_diff(at) <= 2 * HALF);
        let motion: Vec<[f64; 3]> =
            (HALF..rows - HALF).map(|at| signals.kernels.at(signals.position, at, signals.period_s)).collect();
        // Friction turns within a stretch that the speed crosses zero in: neither direction is true of it.
        let one_way = |at: usize| {
            let stretch = &motion[at - 2 * HALF..=at];
            stretch.iter().all(|[_, w, _]| *w > MOVING) || stretch.iter().all(|[_, w, _]| *w < -MOVING)
        };
        for at in (2 * HALF..rows - 2 * HALF).step_by(STRIDE).filter(|&at| !near_gap(at) && one_way(at)) {
            let [_, speed, acceleration] = motion[at - HALF];
            self.push(machine, &signals, at, recording.t_s[at], speed, acceleration);
        }
    }

    fn push(&mut self, machine: &Machine, signals: &Signals<'_>, at: usize, t_s: f64, w: f64, acceleration: f64) {
        let smooth = |signal: &[f64]| signals.kernels.torque(signal, at);
        let plant = &machine.plant;
        let (sign, torque, er) = (w.signum(), smooth(&signals.acting), smooth(&signals.er));
        let known = torque - sign * (plant.coulomb + er) - plant.viscous * w;
        let angle = signals.position[at];
        let mut row: Vec<f64> = Vec::with_capacity(64);
        let mut groups: Vec<Group> = Vec::new();
        let mut group = |id: &'static str, values: &[f64]| {
            groups.push(Group { id, columns: row.len()..row.len() + values.len() });
            row.extend_from_slice(values);
        };
        group("coulomb_friction", &[-sign]);
        group("viscous_friction", &[-w]);
        group("quadratic_drag", &[-w * w.abs()]);
        group("friction_asymmetry", &[-1.0, -w.abs()]);
        group("torque_offset", &[1.0]);
        group("torque_gain", &[torque]);
        group("inertia", &[-acceleration]);
        group("spring_load", &[-angle]);
        group("gravity_load", &[angle.sin(), angle.cos()]);
        group("er_strength", &[-sign * er]);
        group("er_drift", &[-sign * er * t_s]);
        group("field_gain", &[-sign * smooth(&signals.er_slope)]);
        group("torque_deadband", &[-signals.torque[at].signum()]);
        STRIBECK.iter().for_each(|speed| group("stribeck_friction", &[-sign * (-(w / speed).powi(2)).exp()]));
        ORDERS.iter().for_each(|order| group("cogging", &[(order * angle).sin(), (order * angle).cos()]));
        for (k, delay_s) in DELAYS_S.iter().enumerate() {
            let back = (delay_s / signals.period_s).round() as usize;
            let delayed = smooth_back(signals, back, at);
            group("torque_delay", &[delayed - torque]);
            let [dead, lag] = signals.er_delayed[at * DELAYS_S.len() + k];
            group("field_dead_time", &[-sign * (dead - er)]);
            group("field_lag", &[-sign * (lag - er)]);
        }
        self.residual.push(known - plant.inertia * acceleration);
        self.groups = groups;
        // The residual is what the model leaves: the columns explain its negative.
        self.rows.push(row.into_iter().map(|value| -value).collect());
    }

    /// Columns of these groups.
    pub(super) fn columns_of(&self, groups: &[usize]) -> Vec<usize> {
        groups.iter().flat_map(|&group| self.groups[group].columns.clone()).collect()
    }

    /// Root mean square of the residual.
    pub(super) fn rms(&self) -> f64 {
        self.rms_after(&[], &[])
    }

    /// Root mean square of what these columns with these weights leave.
    pub(super) fn rms_after(&self, columns: &[usize], weights: &[f64]) -> f64 {
        let left = |(row, residual): (&Vec<f64>, &f64)| {
            let explained: f64 = columns.iter().zip(weights).map(|(&column, weight)| row[column] * weight).sum();
            (residual - explained).powi(2)
        };
        (self.rows.iter().zip(&self.residual).map(left).sum::<f64>() / self.residual.len().max(1) as f64).sqrt()
    }
}

/// Smoothed acting torque some rows ago, as far as the recording goes back.
fn smooth_back(signals: &Signals<'_>, back: usize, at: usize) -> f64 {
    signals.kernels.torque(&signals.acting, at.saturating_sub(back).max(HALF))
}

impl<'a> Signals<'a> {
    fn new(machine: &Machine, recording: &'a Recording, kernels: Kernels, period_s: f64) -> Self {
        let plant = &machine.plant;
        let torque = recording.effort_cmd.clone();
        let limit = plant.torque_limit.unwrap_or(f64::INFINITY);
        let sent: Vec<f64> =
            torque.iter().map(|nm| (plant.torque_gain * nm + plant.torque_offset).clamp(-limit, limit)).collect();
        let acting = delayed(&sent, plant.torque_delay_from_sample_s() / period_s);
        let field = recording.field_cmd_kv_mm.clone().unwrap_or_else(|| vec![0.0; torque.len()]);
        let (a, b, dead_s, lag_s) =
            plant.er.as_ref().map_or((0.0, 0.0, 0.0, 0.0), |er| (er.a, er.b, er.dead_time_s, er.lag_s));
        let dead_s = dead_s + plant.sample_to_output_s;
        let law = |field: &[f64]| field.iter().map(|e| (a * e + b) * e).collect::<Vec<f64>>();
        let now = lagged(&delayed(&field, dead_s / period_s), lag_s / period_s);
        let mut er_delayed = vec![[0.0; 2]; field.len() * DELAYS_S.len()];
        for (k, more_s) in DELAYS_S.iter().enumerate() {
            let dead = law(&lagged(&delayed(&field, (dead_s + more_s) / period_s), lag_s / period_s));
            let lag = law(&lagged(&delayed(&field, dead_s / period_s), (lag_s + more_s) / period_s));
            for at in HALF..field.len().saturating_sub(HALF) {
                er_delayed[at * DELAYS_S.len() + k] = [kernels.torque(&dead, at), kernels.torque(&lag, at)];
            }
        }
        let er_slope = now.iter().map(|e| (2.0 * a * e + b) * e).collect();
        Self { kernels, period_s, position: &recording.position, torque, er: law(&now), er_slope, er_delayed, acting }
    }
}

/// A held signal some rows late, at the instants of the rows: half a row later than the rows that hold it, or every
/// recording would read as one of a delayed drive.
fn delayed(signal: &[f64], rows: f64) -> Vec<f64> {
    let late = rows + 0.5;
    let (whole, share) = (late.floor() as usize, late.fract());
    let back = |at: usize, rows: usize| if at >= rows { signal[at - rows] } else { 0.0 };
    (0..signal.len()).map(|at| (1.0 - share) * back(at, whole) + share * back(at, whole + 1)).collect()
}

/// A signal at the instants of the rows through a first-order lag of some rows, by the rule of trapezoids: the rule of
/// rectangles is half a row ahead.
fn lagged(signal: &[f64], rows: f64) -> Vec<f64> {
    let follow = |(state, last): &mut (f64, f64), input: &f64| {
        *state = ((2.0 * rows - 1.0) * *state + *last + input) / (2.0 * rows + 1.0);
        *last = *input;
        Some(if rows > 0.0 { *state } else { *input })
    };
    signal.iter().scan((0.0, 0.0), follow).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual::testing::{same_delays, swinging};

    #[test]
    fn torque_and_field_act_after_the_time_to_the_output_and_their_delays() {
        let recording = swinging();
        let tables = same_delays().map(|machine| {
            let mut table = Table::default();
            table.add(&machine, &recording);
            table
        });
        assert!(tables[0].residual.len() > 10);
        assert_eq!(tables[0].residual, tables[1].residual);
        assert_eq!(tables[0].rows, tables[1].rows);
    }
}
