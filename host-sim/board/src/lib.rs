//! The emulated board: an STM32F427 that runs the flashed image unmodified, with the resolver converter and the DAC on its
//! SPI buses, the pins, the field monitor, a serial terminal on USART2, a probe on its RTT channel, and the servo behind
//! it all.
//!
//! It counts instructions, not cycles: what it says of behaviour and of instruction counts is worth something, what it
//! says of time is not.

pub mod bench;
pub mod chip;
pub mod core;
pub mod flash;
pub mod host;
pub mod machine;
pub mod rotor;
pub mod rtt;
pub mod tcp;
pub mod terminal;
pub mod world;
