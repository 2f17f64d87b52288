//! How many claims of sections VI and VII hold together, over L.

use super::NamedFigure;
use crate::paper::case::Reading;
use crate::paper::claims::Joint;
use crate::paper::scan::{GAINS_DELAYS_S, SLOWNESSES};
use crate::plot::{Figure, Mark, Panel, Series, Stroke};

pub(super) fn figure(joint: &Joint) -> NamedFigure {
    let panel = |reading: Reading| {
        let mut series = Vec::new();
        for (hold, stroke) in [(false, Stroke::Solid), (true, Stroke::Dashed)] {
            for slowness in SLOWNESSES {
                let points = GAINS_DELAYS_S.map(|delay_s| {
                    let here = joint.grid.iter().filter(|machine| {
                        let point = machine.point;
                        machine.reading == reading
                            && point.law.hold == hold
                            && point.slowness == slowness
                            && point.gains_delay_s == delay_s
                    });
                    (delay_s * 1e3, here.map(|machine| machine.count()).max().map_or(f64::NAN, |count| count as f64))
                });
                let brake = if hold { "holding" } else { "strict" };
                series.push(Series::new(&format!("{slowness} times, {brake}"), Mark::Line, points).with(stroke));
            }
        }
        Panel::new("L of the gains (ms)", &format!("claims, {} (1)", reading.name()), series)
    };
    let title = "Claims of sections VI and VII that hold together at the best step and Q1; plant so many times as slow";
    let figure = Figure { title: title.to_owned(), panels: Reading::ALL.map(panel).to_vec() };
    NamedFigure { file: "claims_together.svg", figure }
}
