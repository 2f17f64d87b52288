//! What goes between the image and a host: its log, decoded ([`log`]), and its command link, spoken ([`client`] makes and
//! reads the bytes, [`connection`] carries them and waits for answers, [`parameter`] knows the drive's parameters by name,
//! [`telemetry`] reads recordings that come over it).
#![forbid(unsafe_code)]

pub mod client;
pub mod connection;
pub mod log;
pub mod parameter;
pub mod telemetry;
