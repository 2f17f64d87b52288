//! The residual over the channels of state.

use super::bootstrap::share;
use super::leftover::predicted;
use super::order::standing_order;
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
    let steps: Vec<Vec<FieldStep>> = motions.iter().map(|m| field_steps(m.field.as_deref(), &m.t_s)).collect();
    let since = |recording: usize, t_s: f64| {
        let before = steps[recording].partition_point(|step| step.t_s <= t_s);
        (before > 0).then(|| t_s - steps[recording][before - 1].t_s)
    };
    vec![
        over("direction", &|r, sample, _| Some(motions[r].speed[sample].signum())),
        over(speed, &|r, sample, _| Some(motions[r].speed[sample])),
        over(position, &|r, sample, _| Some(motions[r].smooth[sample])),
        over("field_kv_mm", &|r, sample, _| motions[r].field.as_ref().map(|field| field[sample])),
        over("since_field_step_s", &|r, _, t_s| since(r, t_s)),
        over(effort, &|r, sample, _| Some(motions[r].effort[sample])),
        over("t_s", &|_, _, t_s| Some(t_s)),
    ]
}

/// The position within an order per revolution, where one stands out of a fit's residual.
fn within_order(problem: &Problem, fit: &Fit, axis: AxisKind) -> Option<Channel> {
    let order = (axis == AxisKind::Rotary).then(|| standing_order(problem, fit)).flatten()?;
    let middle = problem.equations.iter().enumerate().filter(|(_, equation)| equation.width == 1);
    let points = middle.map(|(index, equation)| {
        let position = equation.row.mean(&problem.motions[equation.recording].cell_position);
        (index, (order as f64 * position).rem_euclid(std::f64::consts::TAU))
    });
    Some(Channel { name: format!("phase_of_order_{order}_rad"), points: points.collect() })
}

/// A jump of the commanded field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FieldStep {
    pub t_s: f64,
    pub rises: bool,
}

/// Jumps of the commanded field by a quarter of its largest value, within one row or a few.
pub(super) fn field_steps(field: Option<&[f64]>, t_s: &[f64]) -> Vec<FieldStep> {
    let Some(field) = field else { return Vec::new() };
    let peak = field.iter().fold(0.0_f64, |peak, e| peak.max(*e));
    let jumps = (1..field.len()).filter(|&row| (field[row] - field[row - 1]).abs() > 0.25 * peak);
    jumps.map(|row| FieldStep { t_s: t_s[row], rises: field[row] > field[row - 1] }).collect()
}

/// Bins of equal numbers of points, in rising order, or one for each value of a channel that has only a few; none where
/// the channel does not vary.
pub(super) fn bins(channel: &Channel) -> Vec<Vec<(usize, f64)>> {
    let mut points = channel.points.clone();
    points.sort_by(|a, b| a.1.total_cmp(&b.1));
    let varies = points.len() >= 4 * BINS && points[points.len() - 1].1 - points[0].1 > 1e-9;
    if !varies {
        return Vec::new();
    }
    let values: Vec<&[(usize, f64)]> = points.chunk_by(|a, b| a.1 == b.1).collect();
    if values.len() <= BINS {
        return values.into_iter().map(<[(usize, f64)]>::to_vec).collect();
    }
    (0..BINS).map(|bin| points[bin * points.len() / BINS..(bin + 1) * points.len() / BINS].to_vec()).collect()
}

/// Ranges of each channel that hold most of the excess of a fit, most telling first.
pub fn regions(problem: &Problem, fit: &Fit, axis: AxisKind) -> Vec<Region> {
    let all = channels(problem, axis).into_iter().chain(within_order(problem, fit, axis));
    let mut all: Vec<(f64, Region)> = all.filter_map(|channel| region(problem, fit, channel)).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().map(|(_, region)| region).collect()
}

/// The range of a channel around its worst bin, and how many times its share of the points its share of the excess is.
fn region(problem: &Problem, fit: &Fit, channel: Channel) -> Option<(f64, Region)> {
    let bins = bins(&channel);
    let square = |index: usize| fit.residual[index].powi(2) - 1.0;
    let excess: Vec<f64> = bins.iter().map(|bin| bin.iter().map(|(index, _)| square(*index)).sum()).collect();
    // Bins of few values differ in size: the worst is the one with the most in each point.
    let density: Vec<f64> = excess.iter().zip(&bins).map(|(excess, bin)| excess / bin.len() as f64).collect();
    let top = (0..bins.len()).max_by(|&a, &b| density[a].total_cmp(&density[b]))?;
    if density[top] <= 0.0 {
        return None;
    }
    // Neighbours with at least half the top's excess belong to it.
    let (mut from, mut to) = (top, top);
    while from > 0 && density[from - 1] > 0.5 * density[top] {
        from -= 1;
    }
    while to + 1 < bins.len() && density[to + 1] > 0.5 * density[top] {
        to += 1;
    }
    let in_blocks = |bins: &[Vec<(usize, f64)>]| {
        let mut sums = vec![0.0; problem.blocks];
        bins.iter().flatten().for_each(|(index, _)| sums[problem.equations[*index].block] += square(*index));
        sums
    };
    let share = share(&in_blocks(&bins[from..=to]), &in_blocks(&bins));
    let points = |bins: &[Vec<(usize, f64)>]| bins.iter().map(Vec::len).sum::<usize>() as f64;
    let surprise = share.share / (points(&bins[from..=to]) / points(&bins));
    let (low, high) = (bins[from].first()?.1, bins[to].last()?.1);
    let Channel { name, .. } = channel;
    Some((
        surprise,
        Region { channel: name, low, high, share: share.share, share_low: share.low, share_high: share.high },
    ))
}

/// A map of one direction is shown where both together predict this much more of the squares than the map of the channel.
const BY_DIRECTION: f64 = 0.05;

/// Mean residual torque over each channel with its 95 % band, N m (N), most telling first. What turns with the motion
/// cancels in a mean over both directions; such a channel has a map for each.
pub fn residual_map(problem: &Problem, fit: &Fit, weights: &[f64], axis: AxisKind) -> Vec<ResidualMap> {
    let map = |channel: &Channel, predicts: f64| map(fit, weights, channel, predicts);
    let mut maps = Vec::new();
    for channel in channels(problem, axis) {
        let predicts = predicted(problem, fit, &channel);
        let parts = by_direction(problem, &channel);
        let each = parts.each_ref().map(|part| predicted(problem, fit, part));
        let squares =
            parts.each_ref().map(|part| part.points.iter().map(|(i, _)| fit.residual[*i].powi(2)).sum::<f64>());
        let apart = (each[0] * squares[0] + each[1] * squares[1]) / (squares[0] + squares[1]).max(1e-300);
        // Speed and direction have the directions apart already.
        let split =
            !channel.name.starts_with("speed") && channel.name != "direction" && apart > predicts + BY_DIRECTION;
        if split {
            maps.extend(parts.iter().map(|part| map(part, apart)));
        } else {
            maps.push(map(&channel, predicts));
        }
    }
    maps.retain(|map| !map.at.is_empty());
    maps.sort_by(|a, b| b.predicts.total_cmp(&a.predicts));
    maps
}

/// A channel forwards and backwards.
fn by_direction(problem: &Problem, channel: &Channel) -> [Channel; 2] {
    [("forwards", 1.0), ("backwards", -1.0)].map(|(name, sign)| {
        let same_way = |(index, _): &&(usize, f64)| {
            let equation = &problem.equations[*index];
            equation.row.mean(&problem.motions[equation.recording].cell_sign) * sign > 0.0
        };
        let points = channel.points.iter().filter(same_way).copied().collect();
        Channel { name: format!("{}, {name}", channel.name), points }
    })
}

fn map(fit: &Fit, weights: &[f64], channel: &Channel, predicts: f64) -> ResidualMap {
    let mut map = ResidualMap { channel: channel.name.clone(), predicts, ..ResidualMap::default() };
    for bin in bins(channel) {
        let count = bin.len() as f64;
        let torque = |index: usize| fit.residual[index] / weights[index];
        let mean = bin.iter().map(|(index, _)| torque(*index)).sum::<f64>() / count;
        let squares: f64 = bin.iter().map(|(index, _)| (torque(*index) - mean).powi(2)).sum();
        map.at.push(bin.iter().map(|(_, value)| value).sum::<f64>() / count);
        map.mean.push(mean);
        // Half-overlapping bumps: every second equation counts.
        map.band.push(1.96 * (2.0 * squares / (count - 1.0) / count).sqrt());
    }
    map
}
