//! Last stage: what was found, in words, figures and pictures.

pub mod compare;
mod units;

pub use units::Units;
