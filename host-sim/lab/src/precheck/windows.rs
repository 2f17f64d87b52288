//! Short windows of a recording: motion by a parabola, everything else by the mean that belongs to its curvature.

use crate::read::{AxisKind, Machine, Recording};

/// Windows looked at for each length; more tell no more.
const MOST: usize = 500;
/// Fewest rows of a window: a parabola has three values.
const FEWEST_ROWS: usize = 8;
/// Shares of the travel that a window must move by to show a direction.
const MOVES_BY: f64 = 1e-3;

/// One window of the torque balance.
#[derive(Debug, Clone)]
pub(crate) struct Window {
    /// Mean speed, rad/s (m/s).
    pub speed: f64,
    /// Acceleration, rad/s2 (m/s2).
    pub acceleration: f64,
    /// Acting torque or force as the model has it, N m (N).
    pub effort: f64,
    /// What else may act: a constant, direction, speed, position, gravity, and the fluid where there is a field.
    pub others: Vec<f64>,
}

/// The lower median of the steps of time, s; 0 of fewer than two rows.
pub(crate) fn median_period_s(t_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> = t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() {
        return 0.0;
    }
    let middle = (steps.len() - 1) / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Windows of about `length_s` that move and hold no gap, each half over the one before, or spread evenly where those were
/// more than are looked at.
pub(crate) fn windows(machine: &Machine, recording: &Recording, period_s: f64, length_s: f64) -> Vec<Window> {
    let rows = ((length_s / period_s).round() as usize).max(FEWEST_ROWS);
    let all = recording.rows();
    if all < rows {
        return Vec::new();
    }
    let stride = (rows / 2).max((all - rows) / MOST).max(1);
    let (low, high) = super::range(&recording.position);
    let least = (MOVES_BY * (high - low)).max(4.0 * machine.axis.resolution);
    let spans = (0..=all - rows).step_by(stride).map(|start| start..start + rows);
    let whole = spans.filter(|span| {
        let gap = recording.gaps.partition_point(|gap| *gap < span.start);
        let (low, high) = super::range(&recording.position[span.clone()]);
        recording.gaps.get(gap).is_none_or(|gap| gap + 1 >= span.end) && high - low > least
    });
    whole.filter_map(|span| window(machine, recording, span)).collect()
}

fn window(machine: &Machine, recording: &Recording, span: std::ops::Range<usize>) -> Option<Window> {
    let t_s = &recording.t_s[span.clone()];
    let (first_s, last_s) = (*t_s.first()?, *t_s.last()?);
    let (middle_s, half_s) = (0.5 * (first_s + last_s), 0.5 * (last_s - first_s));
    if half_s <= 0.0 {
        return None;
    }
    let at = |t_s: f64| (t_s - middle_s) / half_s;
    let (slope, curvature) = parabola(t_s.iter().map(|t| at(*t)), &recording.position[span.clone()])?;
    let (speed, acceleration) = (slope / half_s, curvature / (half_s * half_s));
    // The curvature of the best parabola is the mean of the second derivative under the weight (1 - s^2)^2, by parts twice.
    let mut sum = 0.0;
    let mut effort = 0.0;
    let mut others = Vec::new();
    for row in span {
        let s = at(recording.t_s[row]);
        let weight = (1.0 - s * s).powi(2);
        sum += weight;
        effort += weight * acting(machine, recording, row);
        let terms = terms(recording, row, speed + acceleration * s * half_s);
        others.resize(terms.len(), 0.0);
        others.iter_mut().zip(terms).for_each(|(other, term)| *other += weight * term);
    }
    others.iter_mut().for_each(|other| *other /= sum);
    (sum > 0.0).then_some(Window { speed, acceleration, effort: effort / sum, others })
}

/// Slope and second derivative at 0 of the best parabola through points over s.
fn parabola(s: impl Iterator<Item = f64> + Clone, values: &[f64]) -> Option<(f64, f64)> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let mut normal = nalgebra::Matrix3::<f64>::zeros();
    let mut right = nalgebra::Vector3::<f64>::zeros();
    for (s, value) in s.zip(values) {
        let row = nalgebra::Vector3::new(1.0, s, 0.5 * s * s);
        normal += row * row.transpose();
        right += row * (value - mean);
    }
    let solution = normal.cholesky()?.solve(&right);
    Some((solution[1], solution[2]))
}

/// The torque that acts at a row by the machine file: commanded a delay ago and scaled, N m (N). Its limit is left out: a torque
/// in another unit is beyond it.
fn acting(machine: &Machine, recording: &Recording, row: usize) -> f64 {
    let plant = &machine.plant;
    let since_s = recording.t_s[row] - plant.torque_delay_from_sample_s();
    let held = recording.t_s.partition_point(|t_s| *t_s <= since_s).max(1) - 1;
    plant.torque_gain * recording.effort_cmd[held] + plant.torque_offset
}

/// What may act beside the commanded torque, each with a factor of its own.
fn terms(recording: &Recording, row: usize, speed: f64) -> Vec<f64> {
    let position = recording.position[row];
    let direction = if speed == 0.0 { 0.0 } else { speed.signum() };
    let mut terms = vec![1.0, direction, speed, position];
    if recording.axis == AxisKind::Rotary {
        terms.extend([position.sin(), position.cos()]);
    }
    if let Some(field) = &recording.field_cmd_kv_mm {
        terms.extend([field[row] * direction, field[row] * field[row] * direction]);
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual::testing::{same_delays, swinging};

    #[test]
    fn the_torque_acts_after_the_time_to_the_output_and_the_delay() {
        let recording = swinging();
        let efforts = same_delays().map(|machine| {
            let found = windows(&machine, &recording, 1e-3, 0.05);
            found.iter().map(|window| window.effort).collect::<Vec<f64>>()
        });
        assert!(efforts[0].len() > 10 && efforts[0].iter().any(|effort| effort.abs() > 0.5));
        assert_eq!(efforts[0], efforts[1]);
    }
}
