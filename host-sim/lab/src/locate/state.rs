//! The residual over the channels of state.

use crate::read::AxisKind;
use crate::report::{Region, ResidualMap};
use crate::screen::{Fit, Problem};

/// Bins of a channel, of equal numbers of equations.
const BINS: usize = 10;

/// A channel's value at each equation of the middle width: index of the equation, value.
pub(super) struct Channel {
    pub name: String,
    pub points: Vec<(usize, f64)>,
}

/// All channels these recordings have.
pub(super) fn channels(problem: &Problem, axis: AxisKind) -> Vec<Channel> {
    let (position, speed, effort) = match axis {
        AxisKind::Rotary => ("position_rad", "speed_rad_s", "torque_cmd_nm"),
        AxisKind::Linear => ("position_m", "speed_m_s", "force_cmd_n"),
    };
    let middle: Vec<usize> =
        (0..problem.equations.len()).filter(|&index| problem.equations[index].width == 1).collect();
    let over = |name: &str, value: &dyn Fn(usize, usize, f64) -> Option<f64>| -> Channel {
        let at = |&index: &usize| {
            let equation = &problem.equations[index];
            let motion = &problem.motions[equation.recording];
            let sample = motion.t_s.partition_point(|t| *t < equation.row.centre_s).min(motion.t_s.len() - 1);
            value(equation.recording, sample, equation.row.centre_s).map(|value| (index, value))
        };
        Channel { name: name.to_owned(), points: middle.iter().filter_map(at).collect() }
    };
    let motions = &problem.motions;
    let steps: Vec<Vec<f64>> = motions.iter().map(|m| field_steps(m.field.as_deref(), &m.t_s)).collect();
    let since = |recording: usize, t_s: f64| {
        let before = steps[recording].partition_point(|step| *step <= t_s);
        (before > 0).then(|| t_s - steps[recording][before - 1])
    };
    vec![
        over(speed, &|r, sample, _| Some(motions[r].speed[sample])),
        over(position, &|r, sample, _| Some(motions[r].smooth[sample])),
        over("field_kv_mm", &|r, sample, _| motions[r].field.as_ref().map(|field| field[sample])),
        over("since_field_step_s", &|r, _, t_s| since(r, t_s)),
        over(effort, &|r, sample, _| Some(motions[r].effort[sample])),
        over("t_s", &|_, _, t_s| Some(t_s)),
    ]
}

/// Times at which the commanded field jumps.
fn field_steps(field: Option<&[f64]>, t_s: &[f64]) -> Vec<f64> {
    let Some(field) = field else { return Vec::new() };
    let peak = field.iter().fold(0.0_f64, |peak, e| peak.max(*e));
    (1..field.len()).filter(|&row| (field[row] - field[row - 1]).abs() > 0.25 * peak).map(|row| t_s[row]).collect()
}

/// Bins of equal numbers of points, in rising order; fewer where the channel does not vary.
pub(super) fn bins(channel: &Channel) -> Vec<Vec<(usize, f64)>> {
    let mut points = channel.points.clone();
    points.sort_by(|a, b| a.1.total_cmp(&b.1));
    let varies = points.len() >= 4 * BINS && points[points.len() - 1].1 - points[0].1 > 1e-9;
    if !varies {
        return Vec::new();
    }
    (0..BINS).map(|bin| points[bin * points.len() / BINS..(bin + 1) * points.len() / BINS].to_vec()).collect()
}

/// Ranges of each channel that hold most of the excess of a fit, most telling first.
pub fn regions(problem: &Problem, fit: &Fit, axis: AxisKind) -> Vec<Region> {
    let mut all = Vec::new();
    for channel in channels(problem, axis) {
        let bins = bins(&channel);
        let excess: Vec<f64> = bins
            .iter()
            .map(|bin| bin.iter().map(|(index, _)| fit.residual[*index].powi(2) - 1.0).sum::<f64>().max(0.0))
            .collect();
        let total: f64 = excess.iter().sum();
        if total <= 0.0 {
            continue;
        }
        let top = (0..bins.len()).max_by(|&a, &b| excess[a].total_cmp(&excess[b])).unwrap_or(0);
        // Neighbours with at least half the top's excess belong to it.
        let (mut from, mut to) = (top, top);
        while from > 0 && excess[from - 1] > 0.5 * excess[top] {
            from -= 1;
        }
        while to + 1 < bins.len() && excess[to + 1] > 0.5 * excess[top] {
            to += 1;
        }
        let share = excess[from..=to].iter().sum::<f64>() / total;
        let (low, high) = (bins[from].first().map_or(0.0, |p| p.1), bins[to].last().map_or(0.0, |p| p.1));
        let surprise = share / ((to - from + 1) as f64 / bins.len() as f64);
        all.push((surprise, Region { channel: channel.name, low, high, share }));
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().map(|(_, region)| region).collect()
}

/// Mean residual torque over each channel with its 95 % band, N m (N).
pub fn residual_map(problem: &Problem, fit: &Fit, weights: &[f64], axis: AxisKind) -> Vec<ResidualMap> {
    let mut maps = Vec::new();
    for channel in channels(problem, axis) {
        let mut map = ResidualMap { channel: channel.name.clone(), at: Vec::new(), mean: Vec::new(), band: Vec::new() };
        for bin in bins(&channel) {
            let count = bin.len() as f64;
            let torque = |index: usize| fit.residual[index] / weights[index];
            let mean = bin.iter().map(|(index, _)| torque(*index)).sum::<f64>() / count;
            let squares: f64 = bin.iter().map(|(index, _)| (torque(*index) - mean).powi(2)).sum();
            map.at.push(bin.iter().map(|(_, value)| value).sum::<f64>() / count);
            map.mean.push(mean);
            // Half-overlapping bumps: every second equation counts.
            map.band.push(1.96 * (2.0 * squares / (count - 1.0) / count).sqrt());
        }
        if !map.at.is_empty() {
            maps.push(map);
        }
    }
    maps
}
