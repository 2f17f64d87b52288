//! The plant against references, closed forms, brute force and itself: one program, which links once.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod brute_force;
mod common;
mod er_fluid;
mod load_heat_ripple;
mod loop_references;
mod physics;
mod references;
mod signals;
mod steps;
mod stiff_work;
