//! Residual torque before and after over the channels of state.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::read::Recording;
use crate::report::Units;
use crate::residual::{Channel, Map, Residual};

/// Bins of a map, at most; windows are shared out evenly.
const BINS: usize = 16;
/// Bins of the map over time: a second each, within these bounds.
const TIME_BINS: (usize, usize) = (8, 60);
/// Windows nearer than this are not taken as independent, s.
const BLOCK_S: f64 = 1.0;
/// The same within a bin of the map over time, which holds one stretch and not many: four windows, s.
const SHORT_BLOCK_S: f64 = 0.2;

/// One map: mean residual torque in each bin, with its 95 % band.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct MapPlot {
    pub title: String,
    pub x_label: String,
    pub y_label: String,
    /// Mean of the channel in each bin, rising.
    pub x: Vec<f64>,
    pub before: Band,
    pub after: Option<Band>,
}

/// A mean with its 95 % band, none where too few blocks of time share the bin.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Band {
    pub mean: Vec<f64>,
    pub half: Vec<Option<f64>>,
}

/// A window: value of the channel, block of time, torque before, torque after.
#[derive(Debug, Clone, Copy)]
struct Point {
    x: f64,
    block: (usize, i64),
    before: f64,
    after: Option<f64>,
}

/// Maps over speed, position and field of all recordings together, and over the time of each.
pub(super) fn all(
    recordings: &[&Recording],
    before: &[Residual],
    after: Option<&[Residual]>,
    units: Units,
) -> Vec<MapPlot> {
    let of =
        |index: usize, channel| points(channel, index, recordings[index], &before[index], after.map(|a| &a[index]));
    let y_label = format!("residual {} ({})", units.effort_name, units.effort);
    let joint = [
        (Channel::Speed, "Over speed", format!("speed ({})", units.speed)),
        (Channel::Position, "Over position", format!("position ({})", units.position)),
        (Channel::Field, "Over the commanded field", "field (kV/mm)".to_owned()),
    ];
    let everything = joint.into_iter().filter_map(|(channel, title, x_label)| {
        let all = (0..recordings.len()).flat_map(|index| of(index, channel)).collect();
        MapPlot::new(title.to_owned(), x_label, y_label.clone(), all, BINS)
    });
    let each = (0..recordings.len()).filter_map(|index| {
        let title = format!("Over the time of {}", recordings[index].name);
        let points = of(index, Channel::Time);
        let duration_s = points.last()?.x - points.first()?.x;
        let bins = (duration_s.round() as usize).clamp(TIME_BINS.0, TIME_BINS.1);
        MapPlot::new(title, "time (s)".to_owned(), y_label.clone(), points, bins)
    });
    everything.chain(each).collect()
}

fn points(
    channel: Channel,
    index: usize,
    recording: &Recording,
    before: &Residual,
    after: Option<&Residual>,
) -> Vec<Point> {
    let block_s = if channel == Channel::Time { SHORT_BLOCK_S } else { BLOCK_S };
    let torques: Option<Vec<f64>> = after.map(|after| after.windows.iter().map(|window| window.torque).collect());
    let values = Map::points(channel, before, recording).unwrap_or_default();
    let with_start = values.into_iter().zip(&before.windows).enumerate();
    with_start
        .map(|(window, ((x, torque), at))| Point {
            x,
            block: (index, (recording.t_s[at.start] / block_s).floor() as i64),
            before: torque,
            after: torques.as_ref().and_then(|torques| torques.get(window).copied()),
        })
        .collect()
}

impl MapPlot {
    /// None where there are too few windows, or the channel never changes.
    fn new(title: String, x_label: String, y_label: String, mut points: Vec<Point>, count: usize) -> Option<Self> {
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let range = points.last()?.x - points.first()?.x;
        if points.len() < 4 * count || range <= 1e-9 {
            return None;
        }
        let bins = bins(&points, count, range / (4.0 * count as f64));
        let x: Vec<f64> = bins.iter().map(|bin| mean_x(bin)).collect();
        let before = Band::new(&bins, |point| point.before);
        let after = points[0].after.is_some().then(|| Band::new(&bins, |point| point.after.unwrap_or(f64::NAN)));
        Some(Self { title, x_label, y_label, x, before, after })
    }
}

/// Sorted points in `count` bins of as many each; bins whose means lie nearer than `apart` are one. A machine that rests
/// half of the time would otherwise fill half of the bins at one place, a spike on the screen.
fn bins(points: &[Point], count: usize, apart: f64) -> Vec<&[Point]> {
    let edge = |bin: usize| bin * points.len() / count;
    let mut starts: Vec<usize> = Vec::with_capacity(count);
    for bin in 0..count {
        let here = mean_x(&points[edge(bin)..edge(bin + 1)]);
        let near = starts.last().is_some_and(|start| here - mean_x(&points[*start..edge(bin)]) < apart);
        if !near {
            starts.push(edge(bin));
        }
    }
    let ends = starts.iter().skip(1).copied().chain([points.len()]);
    starts.iter().zip(ends).map(|(start, end)| &points[*start..end]).collect()
}

fn mean_x(bin: &[Point]) -> f64 {
    bin.iter().map(|point| point.x).sum::<f64>() / bin.len() as f64
}

impl Band {
    fn new(bins: &[&[Point]], torque: impl Fn(&Point) -> f64) -> Self {
        let (mean, half) = bins.iter().map(|bin| mean_and_half(bin, &torque)).unzip();
        Self { mean, half }
    }
}

/// Mean and half-width of its 95 % interval. Windows of one block of time err together, so the blocks' sums are what is
/// independent, and Student's t has as many degrees of freedom as blocks less one.
fn mean_and_half(bin: &[Point], torque: &impl Fn(&Point) -> f64) -> (f64, Option<f64>) {
    let count = bin.len() as f64;
    let mean = bin.iter().map(torque).sum::<f64>() / count;
    let mut by_block: Vec<&Point> = bin.iter().collect();
    by_block.sort_by_key(|point| point.block);
    let sums = by_block
        .chunk_by(|one, next| one.block == next.block)
        .map(|block| block.iter().map(|point| torque(point) - mean).sum::<f64>());
    let (squares, blocks) = sums.fold((0.0, 0.0), |(squares, blocks), sum| (squares + sum * sum, blocks + 1.0));
    // Three blocks leave two degrees of freedom, below which an interval says nothing.
    if blocks < 3.0 {
        return (mean, None);
    }
    let error = (squares * blocks / (blocks - 1.0)).sqrt() / count;
    let quantile = StudentsT::new(0.0, 1.0, blocks - 1.0).ok().map(|t| t.inverse_cdf(0.975));
    (mean, quantile.map(|quantile| quantile * error))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn bins_at_one_place_are_one() {
        let at = |x: f64| Point { x, block: (0, 0), before: 0.0, after: None };
        let resting = [-8.0, -4.0, 0.0, 0.0, 0.001, 0.002, 4.0, 8.0].map(at);
        let sizes: Vec<usize> = bins(&resting, 8, 0.5).iter().map(|bin| bin.len()).collect();
        assert_eq!(sizes, [1, 1, 4, 1, 1]);
    }

    #[test]
    fn windows_of_one_block_count_once() {
        let at = |block: i64, before: f64| Point { x: 0.0, block: (0, block), before, after: None };
        let apart: Vec<Point> = (0..12).map(|k| at(k, f64::from(k as i32 % 2))).collect();
        let together: Vec<Point> = (0..12).map(|k| at(k / 3, f64::from(k as i32 / 3 % 2))).collect();
        let half = |bin: &[Point]| mean_and_half(bin, &|point: &Point| point.before).1.unwrap();
        assert!(half(&together) > 1.9 * half(&apart), "{} {}", half(&together), half(&apart));
        assert_eq!(mean_and_half(&[at(0, 1.0), at(1, 3.0)], &|point: &Point| point.before), (2.0, None));
    }
}
