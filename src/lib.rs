//! Control library of the er-servo.
//!
//! One pure function, [`step()`], is the only way into the control law: data in, data out, no register, no clock, no
//! allocation. Firmware, simulation, replay and the emulated board call that same function, so a recording of its
//! [`Inputs`] replays to the bit.
//!
//! ```text
//! resolver code -> counts, faults -> position, speed -> PD -> torque ----+-> limits -> Outputs
//!                        |-> mode (off, damper, brake) -> field ---------+
//!                        supervisor gates both
//! ```
//!
//! # Units and signs
//! rad, s, N m, kV/mm, and resolver counts (491,520 a revolution). A positive torque accelerates towards positive
//! counts; the error is reference minus position. The field has no sign: 0 to 3.5 kV/mm.
//!
//! # Arithmetic
//! Single precision throughout, each operation rounded once (Rust never fuses a multiply-add), no std maths: the same
//! bits on a host and on a Cortex-M4F.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod app;
mod config;
pub mod drivers;
pub mod events;
pub mod experiment;
mod fault;
mod frame;
pub mod guard;
#[cfg(feature = "host-sim")]
pub mod host_sim;
mod law;
pub mod link;
pub mod margins;
mod maths;
pub mod motion;
pub mod parameters;
mod snapshot;
mod step;
pub mod storage;
pub mod telemetry;
mod units;

pub use config::{Config, ConfigError, IMAGE_PERIOD_S, Params, SAMPLE_TO_OUTPUT_NS};
pub use fault::{Faults, Limits};
pub use frame::{FRAME_BYTES, FRAME_SCHEMA, Frame, FrameError, Timing};
pub use law::damper::{field_for_damping_kv_mm, viscosity_nm_s_rad};
pub use law::mode::Mode;
pub use law::supervisor::{Request, Supervisor};
pub use snapshot::{STATE_BYTES, SnapshotError};
pub use step::{InputFlags, Inputs, Outputs, ResolverSample, State, step};
pub use units::{COUNTS_PER_POLE_PAIR, COUNTS_PER_REV, Counts, MonitorCode, POLE_PAIRS, RAD_PER_COUNT, ResolverCode};

/// Highest field the fluid and its amplifier may see, kV/mm; no parameter can raise it.
pub const FIELD_CEILING_KV_MM: f32 = 3.5;
/// Highest torque of the motor, N m; no parameter can raise it.
pub const TORQUE_CEILING_NM: f32 = 30.0;
