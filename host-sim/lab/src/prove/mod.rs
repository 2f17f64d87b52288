//! Proof on concealed effects (`diagnosis.md`): draw a machine, write its recordings, seal the truth, diagnose in a
//! separate process that is given the files only, open the seal, count.
//!
//! The seed of a case decides everything about it, its arm included, so that each can be run again alone.

pub mod arm;
pub mod case;
pub mod judge;
pub mod plan;
pub mod run;
pub mod table;

pub use arm::Arm;
pub use judge::Outcome;
pub use plan::{Blueprint, plan};
