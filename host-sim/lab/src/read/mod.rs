//! First stage: machine files and recordings, checked on the way in (`recording.md` of the specification).

mod columns;
mod controller;
mod csv_file;
mod gaps;
mod machine;
mod machine_file;
mod machine_toml;
mod nearest;
mod parquet_file;
mod position_step;
mod recording;
mod toml_section;
mod values;
pub mod vocabulary;

pub use columns::Column;
pub use machine::{Axis, AxisKind, EffectEntry, ErNominal, Machine, PlantNominal};
pub use position_step::position_step;
pub use recording::{Cells, Mode, Recording};
