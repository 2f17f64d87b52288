//! Machine files and recordings (`recording.md` of the specification): checked on the way in, whole or not at all on the way
//! out. The image's log as recordings ([`decode`]), and a recording held against the control law bit for bit ([`replay`]).
//!
//! Without a terminal and without a command line.
#![forbid(unsafe_code)]

mod column_names;
mod columns;
mod controller;
mod csv_file;
pub mod decode;
mod error;
mod gaps;
mod guess;
mod hdf5_file;
mod in_memory;
mod joints;
mod json_file;
mod log_file;
mod machine;
mod machine_file;
mod machine_toml;
mod map_flag;
mod mapping;
mod mat_file;
mod mcap_file;
mod mend;
mod mode;
mod nearest;
pub mod output;
mod parquet_file;
mod position_step;
mod quiet;
mod recording;
mod recording_file;
pub mod replay;
mod schema;
mod stale;
mod stamps;
mod sysid_file;
mod table;
mod toml_section;
mod topics;
mod ulog_file;
mod units;
mod values;
mod vectors;
pub mod vocabulary;
mod words;
mod wrap;
mod wrong_samples;

pub use columns::Column;
pub use controller::read_parameters;
pub use error::Error;
pub use guess::{Given, Guess, guess};
pub use in_memory::InMemory;
pub use log_file::{FORMATS, readable};
pub use machine::{Axis, AxisKind, EffectEntry, ErElectrode, ErFluid, ErNominal, Machine, PlantNominal};
pub use map_flag::MapFlag;
pub use mapping::{MappedColumn, Mapping};
pub use mode::Mode;
pub use nearest::misspelt;
pub use position_step::position_step;
pub use recording::{BESIDE_THE_LAW, Cells, Recording, places};
pub use table::Table;
pub use values::Cell;
pub use wrap::{Wrap, wrap};
pub use wrong_samples::wrong_samples;
