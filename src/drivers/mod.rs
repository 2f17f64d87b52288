//! Drivers of the two chips on the control path, over the embedded-hal 1.0 traits.
//!
//! The same code runs on the MCU and, on a host, against the byte-level chip models of the `plant` crate. Nothing here
//! panics, allocates or waits, except where a delay is passed in (start-up only).

pub mod ad2s1210;
pub mod dac;
pub mod scaling;
