//! `servo-lab`: the diagnosis, the commands, and the line to a drive. What is read and written is in [`recording`], the
//! closed loop and what follows from law and plant alone in [`analysis`].
//!
//! Flow is one way: a stage knows only what comes before it.
#![forbid(unsafe_code)]

mod asked;
pub mod cli;
pub mod commission;
pub mod conclude;
pub mod delays;
pub mod first_model;
pub mod fleet;
pub mod guide;
pub mod identify;
pub mod interrupt;
pub mod line;
pub mod output;
pub mod precheck;
pub mod progress_bar;
mod progress_line;
pub mod propose;
pub mod prove;
pub mod record;
pub mod report;
pub mod residual;
pub mod session;

// Stages that are crates of their own, under the names they have here.
use analysis::{beyond, paper, plot, simulate, stability, tune};
pub use progress;
pub use recording::{self as read, Error};
use recording::{decode, replay};
