//! The ranking as a picture.

use super::Answer;
use super::plan::Curve;
use crate::plot::{Figure, Mark, Panel, Series, Stroke};

/// Strokes of the models in turn, beside their colours.
const STROKES: [Stroke; 4] = [Stroke::Solid, Stroke::Dashed, Stroke::Dotted, Stroke::DashDot];
/// Evidence beyond this many times that of the nearest model that is out is cut off: what is left must be seen.
const MOST_SHOWN: f64 = 4.0;

/// Where in the recordings each model falls behind the best; and, where several are left, how far apart they are in the best
/// experiment, with the sensor's step.
#[must_use]
pub fn figure(answer: &Answer) -> Figure {
    let out = answer.candidates.iter().filter(|one| !one.in_set).map(|one| one.behind);
    let shown = MOST_SHOWN * out.fold(f64::INFINITY, f64::min);
    let curves = |curves: &[Curve], scale: f64, most: f64| -> Vec<Series> {
        let series = |(at, (name, points)): (usize, &Curve)| {
            let points = points.iter().map(|&(t_s, y)| (t_s, if y.abs() <= most { scale * y } else { f64::NAN }));
            Series::new(name, Mark::Line, points).with(STROKES[at % STROKES.len()])
        };
        curves.iter().enumerate().map(series).collect()
    };
    let drawn = &answer.drawn;
    let mut panels = vec![Panel::new(
        "time over all recordings (s)",
        "log-likelihood below the best (1)",
        curves(&drawn.evidence, 1.0, shown),
    )];
    if let (Some(plan), Some((_, first))) = (answer.plans.first(), drawn.apart.first()) {
        let mut series = curves(&drawn.apart, 1e6, f64::INFINITY);
        let (from, to) = (first.first().map_or(0.0, |point| point.0), first.last().map_or(0.0, |point| point.0));
        let step = 1e6 * drawn.resolution;
        series.push(Series::new("sensor's step", Mark::Line, [(from, step), (to, step)]).with(Stroke::Dotted));
        panels.push(Panel::new(
            &format!("time in a {} (s)", plan.name),
            "position less that of the first (urad)",
            series,
        ));
    }
    Figure { title: "Which delay the fluid has".to_owned(), panels }
}
