//! The judge on recordings of the plant and of real machines: one program, so that two tests run at a time to the end.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod budget;
mod common;
mod fluid;
mod homogeneity;
mod likelihood;
mod load_heat_ripple;
mod nuisances;
mod orders;
mod relevance;
mod shared;
