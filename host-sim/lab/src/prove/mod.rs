//! Proof on concealed effects (`diagnosis.md`): draw a machine, write its recordings, seal the truth, diagnose in a
//! separate process that is given the files only, open the seal, count.
//!
//! The seed of a case decides everything about it, its arm included, so that each can be run again alone.

pub mod answer;
pub mod folder;
pub mod follow;
pub mod judge;
pub mod page;
pub mod power;
pub mod real;
pub mod results;
pub mod rivals;
pub mod run;
pub mod score;
pub mod text;
pub mod tool;

pub use answer::{Answer, Verdict};
pub use judge::Outcome;
pub use score::Score;
