//! One recording, as columns.

use super::AxisKind;

/// What the controller commanded of the damper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// No field.
    Off,
    /// Field from equations (4) and (5).
    Damper,
    /// Constant braking field.
    Brake,
}

/// Samples of one run: columns of equal length, at least one row, time strictly rising.
///
/// Commands of a row are held from its time to the next; the position is sampled at the row's time, before that row's
/// command acts. Units follow [`AxisKind`].
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// File name without its folder, as answers name it.
    pub name: String,
    /// Rotary or linear.
    pub axis: AxisKind,
    /// s.
    pub t_s: Vec<f64>,
    /// rad or m.
    pub position: Vec<f64>,
    /// Commanded torque or force, N m or N.
    pub effort_cmd: Vec<f64>,
    /// rad or m.
    pub reference: Option<Vec<f64>>,
    /// kV/mm.
    pub field_cmd_kv_mm: Option<Vec<f64>>,
    /// Commanded mode of the damper.
    pub mode: Option<Vec<Mode>>,
    /// The controller's speed estimate, rad/s or m/s.
    pub velocity: Option<Vec<f64>>,
    /// Measured torque or force, N m or N.
    pub effort_meas: Option<Vec<f64>>,
    /// Field that acted, kV/mm.
    pub field_meas_kv_mm: Option<Vec<f64>>,
    /// Celsius.
    pub temperature_c: Option<Vec<f64>>,
    /// Sequence number of the control tick.
    pub seq: Option<Vec<u64>>,
    /// Fault word of the controller.
    pub fault: Option<Vec<u32>>,
    /// Position in resolver counts, unwrapped across pole pairs.
    pub counts: Option<Vec<i64>>,
    /// Indices `i` where samples are missing between rows `i` and `i + 1`; the model is simulated across, no residual
    /// is taken there.
    pub gaps: Vec<usize>,
    /// Columns the format does not know, kept as text and reported.
    pub extra: Vec<(String, Vec<String>)>,
}
