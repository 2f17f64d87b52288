//! Physics beyond the nominal machine, one file a group: parameters, their check, their law.
//!
//! Names of effects are those of the diagnosis specification. What belongs to the drive or the field's path is in
//! [`crate::Model`] and [`crate::FieldResponse`] themselves.

pub(crate) mod disturbance;
pub(crate) mod friction;
pub(crate) mod position;
pub(crate) mod shaft;
pub(crate) mod warming;

pub use disturbance::{Pulse, Vibration};
pub use friction::{Asymmetry, Stribeck};
pub use position::{Gravity, Harmonic};
pub use shaft::Shaft;
pub use warming::Warming;
