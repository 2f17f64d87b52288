//! A run as a picture.

use super::Row;
use crate::plot::{Figure, Mark, Panel, Series, Stroke};

/// The field whose a E^2 + b E is a torque, kV/mm; a and b as [`plant::Er::acting`] gives them, for a torque in N m of 0 and above.
#[must_use]
pub fn field_kv_mm((a, b): (f64, f64), torque_nm: f64) -> f64 {
    if a <= 0.0 {
        return if b > 0.0 { torque_nm / b } else { 0.0 };
    }
    let half = b / (2.0 * a);
    (half * half + torque_nm / a).sqrt() - half
}

/// Position against reference, error, speed, torques and fields over time; the fluid's torque is the one that acts, and the
/// field that acts is the one of that torque. `damper` is a and b of the machine's, none for a machine without one.
#[must_use]
pub fn figure(rows: &[Row], damper: Option<(f64, f64)>) -> Figure {
    let series = |name: &str, mark: Mark, value: fn(&Row) -> f64| {
        Series::new(name, mark, rows.iter().map(|row| (row.t_s, value(row))))
    };
    let panel = |label: &str, series: Vec<Series>| Panel::new("time (s)", label, series);
    let mut panels = vec![
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
    ];
    let mut fields = vec![series("command", Mark::Step, |row| f64::from(row.outputs.field_kv_mm)).with(Stroke::Dotted)];
    fields.extend(damper.map(|damper| {
        let acting = rows.iter().map(|row| (row.t_s, field_kv_mm(damper, row.er_torque_nm)));
        Series::new("acts, of the torque", Mark::Line, acting)
    }));
    panels.push(panel("field (kV/mm)", fields));
    Figure { title: "Closed loop of the flashed law and the plant".to_owned(), panels }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use er_servo::{Config, Counts};
    use plant::{Er, Model};

    use super::*;
    use crate::simulate::{Setup, run};

    #[test]
    fn the_field_that_acts_is_drawn_beside_the_command_and_follows_late() {
        let er = Er::new(0.0704, 0.470, 0.002, 0.003);
        let damper = er.acting();
        let setup = Setup {
            model: Model { er: Some(er), ..Model::paper() },
            config: Config::default(),
            disturbances: Vec::new(),
            sensor_noise_rad: 0.0,
            torque_noise_nm: 0.0,
            seed: 0,
        };
        let rows = run(&setup, std::iter::repeat_n(Counts::from_rad(0.05), 400)).unwrap();
        let [.., fields] = &figure(&rows, Some(damper)).panels[..] else { panic!("no panels") };
        assert_eq!(fields.y_label, "field (kV/mm)");
        let [command, acts] = &fields.series[..] else { panic!("{:?}", fields.series.len()) };
        // Dead time and lag on the commands, by hand.
        let (mut acting, keep) = (0.0, (-0.0005_f64 / 0.003).exp());
        for tick in 0..rows.len() {
            assert!((acts.points[tick].1 - acting).abs() < 1e-6, "{tick}: {:?}, {acting}", acts.points[tick]);
            let due = tick.checked_sub(4).map_or(0.0, |before| command.points[before].1);
            acting = due + (acting - due) * keep;
        }
        assert!(acts.points.iter().any(|(_, field)| *field > 1.0));
        assert_eq!(figure(&rows, None).panels.last().unwrap().series.len(), 1);
    }

    #[test]
    fn a_torque_has_its_field() {
        for field in [0.0, 0.5, 3.5] {
            for (a, b) in [(0.0704, 0.470), (0.0, 0.470)] {
                assert!((field_kv_mm((a, b), (a * field + b) * field) - field).abs() < 1e-12);
            }
        }
        assert_eq!(field_kv_mm((0.0, 0.0), 0.0), 0.0);
    }
}
