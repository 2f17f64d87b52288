//! What explains a log as well as an effect may, without being one: hypotheses that compete and are never named (`judge.md`).
//!
//! A scaled sensor is not among them: a resolver's turn is a turn whatever its gain, and a linear scale is no less known than
//! the inertia that it would stand for.

mod blurred_command;
mod position_series;
mod scale_of_torques;

use super::Effect;

/// All of them.
pub static NUISANCES: [&Effect; 3] = [&blurred_command::EFFECT, &position_series::EFFECT, &scale_of_torques::EFFECT];
