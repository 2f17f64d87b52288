//! Screening in the weak form: which effects, on top of the nominal machine, predict blocks they were not fitted to.

mod actuation;
mod balance;
mod candidates;
mod fit;
mod internal;
mod load;
mod motion;
mod noise;
mod problem;
mod search;
mod simplex;
mod smoother;
mod weak;

pub use fit::Fit;
pub use motion::Motion;
pub use problem::{Active, Problem};
pub use search::{MAX_P, MIN_GAIN, Outcome, Refitter, Search, Trial, worse};
