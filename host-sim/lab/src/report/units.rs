//! Units of an axis, for labels.

use crate::read::AxisKind;

/// Names and units of the quantities of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Units {
    /// Unit of position.
    pub position: &'static str,
    /// Unit of speed.
    pub speed: &'static str,
    /// torque or force.
    pub effort_name: &'static str,
    /// Unit of torque or force.
    pub effort: &'static str,
}

/// A unit as it is shown: a plain number has none.
pub(crate) fn shown(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}

impl Units {
    /// Of an axis.
    pub fn of(axis: AxisKind) -> Self {
        match axis {
            AxisKind::Rotary => Self { position: "rad", speed: "rad/s", effort_name: "torque", effort: "N m" },
            AxisKind::Linear => Self { position: "m", speed: "m/s", effort_name: "force", effort: "N" },
        }
    }
}
