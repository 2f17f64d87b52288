//! Small recordings and residuals made by hand, for the tests of this stage.

use plant::State;

use super::{Residual, Window};
use crate::read::{AxisKind, Recording};

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
