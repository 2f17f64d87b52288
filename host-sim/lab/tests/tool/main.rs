//! What the tool as a whole answers and refuses. One program: each links all that reads files, which takes longer than most of what it tests.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../common/mod.rs"]
mod common;
#[path = "../../../analysis/tests/all/common/mod.rs"]
mod servo;

mod comparison;
mod delays;
mod doctor;
mod first_look;
mod fleet;
mod hostile_user;
mod outputs;
mod own_logs;
mod precheck;
mod prove;
mod seen_faults;
mod size;
mod stability;
mod standard_input;
mod sweep;
mod tune_flags;
mod verdicts;
