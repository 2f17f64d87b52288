//! Control library of the er-servo: one pure [`step`], and what it needs.
#![no_std]
#![forbid(unsafe_code)]

mod config;
pub mod drivers;

pub use config::Config;
