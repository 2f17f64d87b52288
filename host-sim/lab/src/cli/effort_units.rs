//! Units of a first model: those of the machine file, or of a current or voltage of which nobody said what one makes.

use crate::read::{AxisKind, Mapping};
use crate::report::Units;

/// Units of what a balance of efforts tells.
pub(super) struct EffortUnits {
    pub(super) effort: String,
    pub(super) inertia: String,
    pub(super) viscous: String,
    pub(super) stiffness: String,
    /// Whether the effort is one in N m (N).
    pub(super) scale_is_known: bool,
}

impl EffortUnits {
    pub(super) fn of(axis: AxisKind, mapping: &Mapping) -> Self {
        let own = Units::of(axis);
        let (inertia, viscous, stiffness) = match axis {
            AxisKind::Rotary => ("kg m2", "N m s/rad", "N m/rad"),
            AxisKind::Linear => ("kg", "N s/m", "N/m"),
        };
        match mapping.unscaled_effort() {
            None => Self {
                effort: own.effort.to_owned(),
                inertia: inertia.to_owned(),
                viscous: viscous.to_owned(),
                stiffness: stiffness.to_owned(),
                scale_is_known: true,
            },
            Some(unit) => Self {
                effort: unit.to_owned(),
                inertia: format!("{unit} s2/{}", own.position),
                viscous: format!("{unit} s/{}", own.position),
                stiffness: format!("{unit}/{}", own.position),
                scale_is_known: false,
            },
        }
    }
}
