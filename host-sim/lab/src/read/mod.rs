//! First stage: machine files and recordings, checked on the way in (`recording.md` of the specification).

mod machine;
mod recording;

pub use machine::{Axis, AxisKind, EffectEntry, ErNominal, Machine, PlantNominal};
pub use recording::{Mode, Recording};
