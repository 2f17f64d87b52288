//! Coulomb level and viscous slope that differ by direction: half the difference is added in +, taken in -.

use plant::effects::Asymmetry;

use super::{Columns, Effect, PLAIN, Size, shown, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "friction_asymmetry",
    sentence: "Friction differs by direction: preload of the screw or bearing, seals, a belt or brush that drags one way.",
    parameters: &[sized(Size::Torque, -1e2, 1e2, 0.05), sized(Size::Damping, -1e2, 1e2, 0.05)],
    starts: |_, _| vec![vec![0.0, 0.0]],
    put: |p, v| p.model.asymmetry = Asymmetry { coulomb: v[0], viscous: v[1] },
    columns: Columns::Each,
    leading: &[0, 1],
    example: shown(|f| vec![0.3 * f, 0.0]),
    ..PLAIN
};
