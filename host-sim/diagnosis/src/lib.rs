//! What physics a model leaves out.
#![forbid(unsafe_code)]

pub mod confidence_set;
pub mod effects;
pub mod goodness;
pub mod hypothesis;
pub mod likelihood;
pub mod locate;
mod nominal;
pub mod physics;
pub mod pipeline;
pub mod problem;
pub mod recorded;
pub mod score;
pub mod search;
pub mod verdict;
pub mod windows;
