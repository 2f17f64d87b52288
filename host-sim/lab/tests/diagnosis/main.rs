//! Diagnosis of recordings made by the plant with one thing changed that the nominal model does not know.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod answers;
mod cases;
mod coverage;
mod many;
mod real;
mod singles;
mod size;
