//! The closed loop of the flashed control law and the plant, and the recording it leaves.

mod closed_loop;
mod plot;
mod scenario;
mod summary;

pub use closed_loop::{ClosedLoop, Disturbance, Row, Setup, period_s, record, run, run_beside};
pub use plot::{field_kv_mm, figure};
pub use scenario::{Positions, Reference, Scenario, in_degrees};
pub use summary::{StepFigures, Summary};
