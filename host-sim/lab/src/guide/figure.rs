//! The picture of an effect.

use diagnosis::recorded::Recorded;

use super::Guide;
use super::sizes::Sized;
use crate::plot::{Figure, Mark, Panel, Series};
use crate::propose::{Item, Loop};
use crate::read::{AxisKind, Recording};
use crate::residual::{Channel, Map, residual};

/// Windows of the residual, s.
const HORIZON_S: f64 = 0.05;

/// Residual torque of the nominal model over the channel that explains most of it, on whichever experiment shows it best.
pub(super) fn figure(guide: &Guide, sized: &Sized, items: &[Item]) -> Option<Figure> {
    let channels = [Channel::Speed, Channel::Position, Channel::Field, Channel::Time];
    let physics = Guide::hypothesis(sized, 1.0).physics(&guide.nominal);
    let drive = Loop::of(&guide.machine, &guide.limits);
    let mut best: Option<(f64, Panel)> = None;
    for item in items {
        let recording = recording(drive.motion(&physics, item)?.recorded, guide.machine.axis.kind);
        let residual = residual(&guide.nominal.model_of(0), &recording, HORIZON_S).ok()?;
        for map in channels.iter().filter_map(|channel| Map::over(*channel, &residual, &recording)) {
            if best.as_ref().is_none_or(|(explained, _)| map.explained > *explained) {
                let points = Map::points(map.channel, &residual, &recording).unwrap_or_default();
                best = Some((map.explained, panel(&map, points, item.name)));
            }
        }
    }
    let (explained, panel) = best?;
    let title = format!("{}: {:.0} % of the squares follow this channel", sized.effect.id, 100.0 * explained);
    Some(Figure { title, panels: vec![panel] })
}

fn recording(recorded: Recorded, axis: AxisKind) -> Recording {
    let commands = &recorded.commands;
    Recording {
        name: recorded.name,
        effort_cmd: commands.iter().map(|command| command.torque).collect(),
        field_cmd_kv_mm: Some(commands.iter().map(|command| command.field_kv_mm).collect()),
        velocity: Some(commands.iter().map(|command| command.speed_estimate).collect()),
        t_s: recorded.t_s,
        position: recorded.position,
        ..Recording::empty(axis)
    }
}

fn panel(map: &Map, points: Vec<(f64, f64)>, motion: &str) -> Panel {
    let label = match map.channel {
        Channel::Direction => "direction",
        Channel::Speed => "speed (rad/s)",
        Channel::Position => "position (rad)",
        Channel::Field => "field (kV/mm)",
        Channel::Time => "time (s)",
    };
    let means = map.bins.iter().map(|bin| (0.5 * (bin.low + bin.high), bin.mean_torque));
    let series = vec![
        Series::new(&format!("windows of 50 ms, {motion}"), Mark::Points, points),
        Series::new("mean of as many windows", Mark::Line, means),
    ];
    Panel::new(label, "residual torque (N m)", series)
}
