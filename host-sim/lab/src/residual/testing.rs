//! Small recordings and residuals made by hand, for the tests of this stage.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use plant::State;

use super::{Residual, Window};
use crate::read::{AxisKind, Machine, Recording};

/// A rotary recording without commands.
pub(crate) fn recording(t_s: Vec<f64>, position: Vec<f64>) -> Recording {
    Recording {
        name: "hand.csv".to_owned(),
        effort_cmd: vec![0.0; t_s.len()],
        t_s,
        position,
        ..Recording::empty(AxisKind::Rotary)
    }
}

/// Windows of ten rows over a recording, with a torque for each.
pub(super) fn residual(recording: &Recording, torque: impl Fn(&[f64], f64) -> f64) -> Residual {
    let windows = (0..recording.rows() / 10).map(|k| {
        let (start, end) = (10 * k, 10 * k + 10);
        let (t_s, position) = (&recording.t_s[start..end], &recording.position[start..end]);
        let speed = (position[9] - position[0]) / (t_s[9] - t_s[0]);
        Window {
            start,
            end,
            state: State::new(position[0], speed),
            residual: vec![0.0; 10],
            torque: torque(position, speed),
            speed,
        }
    });
    Residual { horizon_s: 0.05, windows: windows.collect() }
}

/// One machine twice: with its delays from the sample on, and with a millisecond of them from the sample to the drive's outputs.
pub(crate) fn same_delays() -> [Machine; 2] {
    let with = |to_output_s: f64, torque_delay_s: f64, dead_time_s: f64| {
        let text = format!(
            "schema = 1\nname = \"drive\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 1e-3\nresolution = 1e-5\n\
             [plant]\ninertia = 0.075\ncoulomb = 0.2\nsample_to_output_s = {to_output_s}\n\
             torque_delay_s = {torque_delay_s}\n[plant.er]\na = 0.07\nb = 0.47\ndead_time_s = {dead_time_s}\n"
        );
        Machine::from_bytes(Path::new("m.toml"), text.as_bytes()).unwrap()
    };
    [with(0.0, 0.005, 0.002), with(0.001, 0.004, 0.001)]
}

/// Two seconds of a swinging axis under a torque and a field that change.
pub(crate) fn swinging() -> Recording {
    let t_s: Vec<f64> = (0..2000).map(|row| f64::from(row) * 1e-3).collect();
    let over = |of: fn(f64) -> f64| t_s.iter().map(|t| of(*t)).collect::<Vec<f64>>();
    Recording {
        position: over(|t| (4.0 * t).sin()),
        effort_cmd: over(|t| 2.0 * (9.0 * t).sin()),
        field_cmd_kv_mm: Some(over(|t| 1.0 + (7.0 * t).sin())),
        t_s,
        ..Recording::empty(AxisKind::Rotary)
    }
}
