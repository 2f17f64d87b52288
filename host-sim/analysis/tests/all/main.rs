//! The paper, its figures and the design on the simulated drive: one program, which links once.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod beyond;
mod common;
mod figures;
mod hostile_input;
mod paper;
mod recorded_loop;
mod section_7;
mod tune;
