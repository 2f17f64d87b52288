//! The firmware of the er-servo: on the MCU the image, on a host what it would do.
#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(target_os = "none")]
mod fw;

#[cfg(not(target_os = "none"))]
fn main() {}
