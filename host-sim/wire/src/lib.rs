//! What goes between the image and a host: its log, decoded ([`log`]), and its command link, spoken ([`client`]).
#![forbid(unsafe_code)]

pub mod client;
pub mod log;
