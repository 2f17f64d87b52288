//! What physics a model of a servo leaves out, by one likelihood: a library without files and without a terminal.
//!
//! ```text
//! recorded, problem -> likelihood -> score -> hypothesis, search -> confidence_set -> goodness -> verdict; pipeline knows them all
//! ```
//!
//! A value made by one stage is never changed by a later one. `docs/method.md` has the equations and the sources.
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
pub mod ranking;
pub mod recorded;
pub mod remainder;
pub mod repetition;
pub mod score;
pub mod search;
pub mod separation;
pub mod verdict;
pub mod windows;
pub mod work;
