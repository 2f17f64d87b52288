//! A weight on an arm: -amplitude sin(th + phase).

use plant::effects::Gravity;

use super::{Columns, Effect, HOLDING, PLAIN, Size, shown, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "gravity_load",
    sentence: "An unbalanced weight pulls with the angle: an arm, a payload off centre, an axis that is not vertical.",
    parameters: &[sized(Size::Torque, -1e2, 1e2, 0.05), sized(Size::Torque, -1e2, 1e2, 0.05)],
    applies: |_, e| !e.linear && e.travel > 0.2,
    starts: |_, _| vec![vec![0.0, 0.0]],
    put: |p, v| p.model.gravity = Some(Gravity { amplitude: v[0].hypot(v[1]), phase_rad: v[1].atan2(v[0]) }),
    report: |v| vec![v[0].hypot(v[1]), v[1].atan2(v[0])],
    fitted: |v, _| Some(vec![v[0] * v[1].cos(), v[0] * v[1].sin()]),
    columns: Columns::Each,
    measured_by: Some(HOLDING),
    example: shown(|f| vec![0.46 * f, 0.2 * f]),
    ..PLAIN
};
