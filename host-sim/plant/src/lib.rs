//! Physics of the servo in double precision: drive, electrorheological damper, rotor with true stiction, sensor.
//!
//! The crate knows no control law. Commands go in, motion comes out, in two ways that share every equation:
//!
//! - [`Plant`]: closed loop, one command at a time ([`Plant::advance`]).
//! - [`Timeline`] and [`Mechanics`]: the commands are known in advance (a recording). The timeline turns them once into
//!   what acts on the rotor; the mechanics then runs from any time and state ([`Mechanics::simulate`]).
//!
//! ```text
//! Command -> actuation: limits, delays, lags -> Segment: torque and field as formulas of time
//!         -> mechanics: exact or high-order motion between events -> State -> sensor
//! ```
//!
//! Nothing here steps time by brute force. On a [`Segment`] everything that acts is a formula, so the nominal machine
//! is integrated in closed form; what has no closed form goes through collocation of order eight. Reversal, sticking,
//! break-away, yield and contact are located in time. Cutting a tick in two changes no effect by more than 1e-11 rad.
//! Very stiff parameters (bristles beyond 1e9 N m/rad, resonances beyond 10 kHz) stay right but cost many steps a tick.
//!
//! # Units
//!
//! SI throughout. One model serves rotary (rad, N m, kg m2) and linear (m, N, kg) axes: "torque" reads "force", "rad"
//! reads "m". The electric field is in kV/mm, as in the fluid's law.
#![forbid(unsafe_code)]

mod actuation;
pub mod chips;
mod command;
pub mod effects;
pub mod er_fluid;
mod error;
pub mod laws;
mod mechanics;
mod model;
mod plant;
pub mod sensor;
mod timeline;

pub use actuation::{Segment, Signal};
pub use command::Command;
pub use error::Error;
pub use mechanics::{Mechanics, Motion, State};
pub use model::{Er, FieldResponse, FluidResponse, HIGHEST_FIELD_KV_MM, Model};
pub use plant::Plant;
pub use timeline::Timeline;
