//! The stages of `servo-lab`, in the order data takes through them: [`read`], then the later stages.
//!
//! Flow is one way: a stage knows only what comes before it.
#![forbid(unsafe_code)]

pub mod cli;
pub mod decide;
pub mod decode;
pub mod effects;
pub mod formula;
pub mod guide;
pub mod interrupt;
pub mod line;
pub mod locate;
pub mod output;
pub mod paper;
pub mod plot;
pub mod progress;
pub mod propose;
pub mod prove;
pub mod record;
pub mod refit;
pub mod replay;
pub mod report;
pub mod residual;
pub mod screen;
pub mod simulate;
pub mod stability;
pub mod tune;

pub use recording as read;
pub use recording::Error;
