//! Screening in the weak form: which effects, on top of the nominal machine, predict blocks they were not fitted to.

mod actuation;
mod attempt;
mod balance;
mod candidates;
mod fit;
mod instrument;
mod internal;
mod judge;
mod load;
mod motion;
mod noise;
mod problem;
mod refitter;
mod search;
mod simplex;
mod smoother;
mod waves;
mod weak;

pub(crate) use actuation::{Chain, chain_means};
pub(crate) use balance::{damper, drive, yield_level};
pub(crate) use candidates::orders_of;
pub use fit::Fit;
pub(crate) use fit::{bounded_step, moved, places, solve_near};
pub(crate) use instrument::effort_filter_s;
pub use judge::{MAX_P, MIN_GAIN, Trial, worse};
pub(crate) use judge::{MIN_T, WORSE_T, f_test, fall_t, paired_t, t_of_mean, tail};
pub(crate) use load::Bounce;
pub use motion::Motion;
pub use problem::{Active, Problem};
pub use refitter::Refitter;
pub(crate) use search::SCALE;
pub use search::{Outcome, Search};
pub(crate) use simplex::minimise;
