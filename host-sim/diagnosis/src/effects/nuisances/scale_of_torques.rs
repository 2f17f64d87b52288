//! All torques against the inertia are larger by a factor: what a wrong inertia, unit or scale of the log does.

use super::super::{Columns, Effect, PLAIN, Size, sized};

/// The hypothesis. It is the inertia under another name, so it competes where `inertia` may not be named.
pub static EFFECT: Effect = Effect {
    id: "scale_of_torques",
    sentence: "one factor on all torques against the inertia",
    parameters: &[sized(Size::Inertia, 0.3, 4.0, 0.05)],
    starts: |p, _| vec![vec![p.model.inertia]],
    put: |p, v| p.model.inertia = v[0],
    neutral: |p| p.model.inertia,
    columns: Columns::Each,
    alike: &["inertia"],
    nameable: false,
    ..PLAIN
};
