//! The picture of an effect.

use crate::plot::{Figure, Mark, Panel, Series};
use crate::propose::{Item, Request, Rival, mismatch};
use crate::residual::{Channel, Map};

/// Residual torque of the nominal model over the channel that explains most of it, on whichever experiment shows it best.
pub(super) fn figure(request: &Request<'_>, effect: &Rival, nominal: &Rival, items: &[Item]) -> Option<Figure> {
    let channels = [Channel::Speed, Channel::Position, Channel::Field, Channel::Time];
    let mut best: Option<(f64, Panel)> = None;
    for item in items {
        let (residual, recording) = mismatch(request, effect, nominal, item)?;
        for map in channels.iter().filter_map(|channel| Map::over(*channel, &residual, &recording)) {
            if best.as_ref().is_none_or(|(explained, _)| map.explained > *explained) {
                let points = Map::points(map.channel, &residual, &recording).unwrap_or_default();
                best = Some((map.explained, panel(&map, points, item.name)));
            }
        }
    }
    let (explained, panel) = best?;
    let title = format!("{}: {:.0} % of the squares follow this channel", effect.id, 100.0 * explained);
    Some(Figure { title, panels: vec![panel] })
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
