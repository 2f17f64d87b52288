//! Screening in the weak form: which effects, on top of the nominal machine, predict blocks they were not fitted to.

mod actuation;
mod balance;
mod candidates;
mod fit;
mod internal;
mod motion;
mod noise;
mod problem;
mod search;
mod smoother;
mod weak;

pub(crate) use balance::damper;
pub use fit::Fit;
pub(crate) use fit::{bounded_step, moved, places, solve_near};
pub use motion::Motion;
pub use problem::{Active, Problem};
pub use search::{MAX_P, MIN_GAIN, Outcome, Refitter, Search, Trial, worse};
