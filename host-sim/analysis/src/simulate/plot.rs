//! A run as a picture.

use super::Row;
use crate::plot::{Figure, Mark, Panel, Series, Stroke};

/// Position against reference, error, speed, torques and field over time; the fluid's torque is the one that acts.
#[must_use]
pub fn figure(rows: &[Row]) -> Figure {
    let series = |name: &str, mark: Mark, value: fn(&Row) -> f64| {
        Series::new(name, mark, rows.iter().map(|row| (row.t_s, value(row))))
    };
    let panel = |label: &str, series: Vec<Series>| Panel::new("time (s)", label, series);
    let panels = vec![
        panel(
            "position (rad)",
            vec![
                series("reference", Mark::Step, |row| row.reference.to_rad()).with(Stroke::Dotted),
                series("true position", Mark::Line, |row| row.truth.position),
            ],
        ),
        panel("error (mrad)", vec![series("", Mark::Line, |row| 1e3 * (row.reference.to_rad() - row.truth.position))]),
        panel(
            "speed (rad/s)",
            vec![
                series("the law's", Mark::Step, |row| f64::from(row.outputs.speed_rad_s)).with(Stroke::Dotted),
                series("true", Mark::Line, |row| row.truth.velocity),
            ],
        ),
        panel(
            "torque (N m)",
            vec![
                series("motor, command", Mark::Step, |row| f64::from(row.outputs.torque_nm)),
                series("fluid, at most", Mark::Line, |row| row.er_torque_nm).with(Stroke::Dashed),
            ],
        ),
        panel("field command (kV/mm)", vec![series("", Mark::Step, |row| f64::from(row.outputs.field_kv_mm))]),
    ];
    Figure { title: "Closed loop of the flashed law and the plant".to_owned(), panels }
}
