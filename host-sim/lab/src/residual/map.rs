//! Over which state the residual is largest.

use std::f64::consts::TAU;

use super::window::{Residual, Window};
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
        let mut points = Self::points_of(channel, residual.usual(), recording)?;
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
        Self::points_of(channel, residual.windows.iter(), recording)
    }

    fn points_of<'a>(
        channel: Channel,
        windows: impl Iterator<Item = &'a Window>,
        recording: &Recording,
    ) -> Option<Vec<(f64, f64)>> {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::residual::testing::{recording, residual};

    /// To and fro, twenty times, with 1200 windows.
    fn swinging() -> Recording {
        let t_s: Vec<f64> = (0..12_000).map(|row| f64::from(row) * 5e-4).collect();
        let position = t_s.iter().map(|t| (20.0 * t).sin()).collect();
        recording(t_s, position)
    }

    fn explained(channel: Channel, torque: impl Fn(&[f64], f64) -> f64) -> f64 {
        let recording = swinging();
        Map::over(channel, &residual(&recording, torque), &recording).unwrap().explained
    }

    #[test]
    fn a_torque_is_explained_by_the_channel_it_follows() {
        assert!(explained(Channel::Direction, |_, speed| -2.0 * speed.signum()) > 0.999);
        assert!(explained(Channel::Speed, |_, speed| -0.5 * speed) > 0.97);
        assert!(explained(Channel::Position, |position, _| (3.0 * position[5]).sin()) > 0.95);
        assert!(explained(Channel::Speed, |position, _| (3.0 * position[5]).sin()) < 0.05);
        assert!(explained(Channel::Time, |_, speed| speed.signum()) < 0.05);
    }

    #[test]
    fn chance_explains_nothing() {
        // The far digits of a number follow no channel.
        let chance = |position: &[f64], _| (position[3] * 1e6).rem_euclid(1.0) - 0.5;
        for channel in [Channel::Direction, Channel::Speed, Channel::Position, Channel::Time] {
            let share = explained(channel, chance);
            assert!(share < 0.02, "{channel:?}: {share}");
        }
    }

    #[test]
    fn bins_hold_the_same_number_and_a_true_error() {
        let recording = swinging();
        let map = Map::over(Channel::Speed, &residual(&recording, |_, speed| speed), &recording).unwrap();
        assert!(map.bins.iter().all(|bin| bin.windows == 100 && bin.low <= bin.mean_torque));
        assert!(map.bins.is_sorted_by(|a, b| a.high <= b.low));
        let bin = bin_of(&[(0.0, 1.0), (1.0, 2.0), (2.0, 6.0)]);
        assert_eq!((bin.mean_torque, bin.windows), (3.0, 3));
        // Variance 7 of three values.
        assert!((bin.standard_error - (7.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn channels_that_are_not_there_or_never_change_have_no_map() {
        let recording = swinging();
        let one_way = Recording { position: recording.t_s.clone(), ..recording.clone() };
        assert_eq!(Map::over(Channel::Field, &residual(&recording, |_, w| w), &recording), None);
        assert_eq!(Map::over(Channel::Direction, &residual(&one_way, |_, w| w), &one_way), None);
        let silent = Map::over(Channel::Speed, &residual(&recording, |_, _| 0.0), &recording).unwrap();
        assert_eq!(silent.explained, 0.0);
    }
}
