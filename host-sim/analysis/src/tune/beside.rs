//! The tuned gains beside the mode that won in [`crate::beyond`], which needs more than gains.

use er_servo::Config;

use super::trial::{Trial, trial_of};
use super::{Task, Tuning};
use crate::beyond::{Mode, compare, is_told};
use recording::Error;

/// Why the winner is not what a tuned machine file holds.
pub const NOT_WRITTEN: &str =
    "It is not what tune writes: the machine file holds parameters of the flashed law, and that law has no such mode.";

/// What the winning mode does in the runs that the tuned gains were judged by.
#[derive(Debug, Clone, PartialEq)]
pub struct Beside {
    /// The mode.
    pub mode: Mode,
    /// With every delay off by the uncertainty, as the tuned gains are tried; none where it does not settle as asked then.
    pub uncertain: Option<Trial>,
    /// With the delays it was told.
    pub nominal: Option<Trial>,
}

/// Tries the mode that won; none where no mode won, or on a machine that the modes are not told.
///
/// # Errors
/// A value the law or the plant does not take.
pub fn beside(task: &Task) -> Result<Option<Beside>, Error> {
    if !is_told(&task.model) || !task.config.er_enabled {
        return Ok(None);
    }
    let Some(mode) = compare()?.winner().map(|entry| entry.mode) else { return Ok(None) };
    let tried = |uncertainty| trial_of(Some(&mode), &task.model, &Config::default(), uncertainty, &task.steps);
    Ok(Some(Beside { mode, uncertain: tried(task.uncertainty)?, nominal: tried(0.0)? }))
}

impl Beside {
    /// For a terminal: its figures beside the tuned ones, and why they are not what is written.
    #[must_use]
    pub fn text(&self, task: &Task, tuning: &Tuning) -> String {
        let percent = 100.0 * task.uncertainty;
        let figures = |trial: &Trial| {
            format!(
                "{:.1} and {:.1} ms, overshoot {:.2} %, push {:.1} mrad",
                1e3 * trial.settling_s[0],
                1e3 * trial.settling_s[1],
                100.0 * trial.overshoot,
                1e3 * trial.push_rad
            )
        };
        let or_not = |trial: &Option<Trial>| trial.as_ref().map_or("does not settle as asked".to_owned(), figures);
        format!(
            "beyond the flashed law, the mode \"{}\" (`simulate --mode {}`), settling of the large and the small step:\n  every delay off \
             by {percent:.0} %: {}\n  with the delays told: {}\n  tuned, every delay off by {percent:.0} %: {}\n{NOT_WRITTEN}\n",
            self.mode.name,
            self.mode.key,
            or_not(&self.uncertain),
            or_not(&self.nominal),
            or_not(&tuning.best.trial)
        )
    }
}
