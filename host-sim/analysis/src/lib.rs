//! What needs the control law and the plant, and no diagnosis: the closed loop ([`simulate`]), its linear and nonlinear
//! [`stability`], the claims of the [`paper`], gains that are tuned ([`tune`]), and the figures of all of them ([`plot`]).
#![forbid(unsafe_code)]

pub mod beyond;
pub mod paper;
pub mod plot;
pub mod simulate;
pub mod stability;
pub mod tune;
