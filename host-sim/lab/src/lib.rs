//! The stages of `servo-lab`, in the order data takes through them: [`read`], then the later stages.
//!
//! Flow is one way: a stage knows only what comes before it.
#![forbid(unsafe_code)]

pub mod cli;
pub mod error;
pub mod read;
pub mod stability;

pub use error::Error;
