//! What physics a model leaves out.
#![forbid(unsafe_code)]

pub mod likelihood;
pub mod physics;
pub mod recorded;
