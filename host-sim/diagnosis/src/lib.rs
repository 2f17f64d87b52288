//! What physics a model leaves out.
#![forbid(unsafe_code)]

pub mod effects;
pub mod hypothesis;
pub mod likelihood;
mod nominal;
pub mod physics;
pub mod problem;
pub mod recorded;
pub mod score;
pub mod confidence_set;
pub mod goodness;
pub mod locate;
pub mod pipeline;
pub mod search;
pub mod verdict;
pub mod windows;
