//! Over which state the residual is largest.

use std::f64::consts::TAU;

use super::window::Residual;
use crate::read::{AxisKind, Recording};

/// Bins of a map; windows are shared out evenly, so that each bin means the same.
const BINS: usize = 12;

/// What a map runs over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// Sign of the window's mean speed.
    Direction,
    /// Mean speed of the window.
    Speed,
    /// Mean position of the window; within a revolution where a rotary axis turns more than one.
    Position,
    /// Mean commanded field of the window.
    Field,
    /// Middle of the window.
    Time,
}

/// Windows of like state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bin {
    /// Lowest value of the channel.
    pub low: f64,
    /// Highest value of the channel.
    pub high: f64,
    /// Mean residual torque, N m (N).
    pub mean_torque: f64,
    /// Standard error of that mean, N m (N).
    pub standard_error: f64,
    /// Windows in it.
    pub windows: usize,
}

/// Residual torque over one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// The channel.
    pub channel: Channel,
    /// In rising order of the channel.
    pub bins: Vec<Bin>,
    /// Share of the residual torque's squares that the bins' means explain, less what as many bins of pure chance would.
    pub explained: f64,
}

impl Map {
    /// Maps the residual torque over a channel; none where the recording lacks it or it never changes.
    pub fn over(channel: Channel, residual: &Residual, recording: &Recording) -> Option<Self> {
        let mut points = Self::points(channel, residual, recording)?;
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (low, high) = (points.first()?.0, points.last()?.0);
        let enough = points.len() >= 2 * BINS;
        if !enough || high - low <= 1e-9 * high.abs().max(low.abs()) {
            return None;
        }
        let bins: Vec<Bin> = if channel == Channel::Direction {
            points.chunk_by(|a, b| a.0 == b.0).map(bin_of).collect()
        } else {
            let edge = |bin| bin * points.len() / BINS;
            (0..BINS).map(|bin| bin_of(&points[edge(bin)..edge(bin + 1)])).collect()
        };
        let total: f64 = points.iter().map(|(_, torque)| torque * torque).sum();
        let between: f64 = bins.iter().map(|bin| bin.windows as f64 * bin.mean_torque * bin.mean_torque).sum();
        let count = points.len() as f64;
        let free = bins.len() as f64 / count;
        let by_chance = free * (total - between) / (1.0 - free);
        let explained = if total > 0.0 { ((between - by_chance) / total).max(0.0) } else { 0.0 };
        Some(Self { channel, bins, explained })
    }

    /// Value of the channel and residual torque of each window; none where the recording lacks the channel.
    pub fn points(channel: Channel, residual: &Residual, recording: &Recording) -> Option<Vec<(f64, f64)>> {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let field = recording.field_cmd_kv_mm.as_ref();
        if channel == Channel::Field && field.is_none() {
            return None;
        }
        let (low, high) = recording
            .position
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        // Only an axis that turns right round comes back to the same place at another position.
        let turns = recording.axis == AxisKind::Rotary && high - low > TAU;
        let value = |start: usize, end: usize, speed: f64| match channel {
            Channel::Direction => speed.signum(),
            Channel::Speed => speed,
            Channel::Position => {
                let position = mean(&recording.position[start..end]);
                if turns { position.rem_euclid(TAU) } else { position }
            }
            Channel::Field => field.map_or(0.0, |field| mean(&field[start..end])),
            Channel::Time => mean(&recording.t_s[start..end]),
        };
        let windows = residual.windows.iter();
        Some(windows.map(|window| (value(window.start, window.end, window.speed), window.torque)).collect())
    }
}

fn bin_of(points: &[(f64, f64)]) -> Bin {
    let count = points.len() as f64;
    let mean_torque = points.iter().map(|(_, torque)| torque).sum::<f64>() / count;
    let squares: f64 = points.iter().map(|(_, torque)| (torque - mean_torque).powi(2)).sum();
    Bin {
        low: points[0].0,
        high: points[points.len() - 1].0,
        mean_torque,
        standard_error: (squares / (count - 1.0).max(1.0) / count).sqrt(),
        windows: points.len(),
    }
}
