//! The two models along the recordings, as the page draws them.

use diagnosis::physics::Physics;
use diagnosis::recorded::ACTS_S;
use diagnosis::windows::HORIZONS_S;
use rayon::prelude::*;

use crate::Error;
use crate::read::Recording;
use crate::residual::{Residual, residual};

/// Wished length of the windows drawn, s; longer where the rows are far apart.
const WINDOW_S: f64 = HORIZONS_S[0];

/// Residuals of a machine in short windows, one for each recording; the first of them is number 0 of the machine's pushes
/// and phases.
///
/// # Errors
/// A recording too short for one window, or a machine that cannot be simulated.
pub(super) fn all(physics: &Physics, recordings: &[&Recording]) -> Result<Vec<Residual>, Error> {
    let each = recordings.par_iter().enumerate().map(|(index, recording)| {
        let mut all = residual(&physics.model_of(index), recording, WINDOW_S)?;
        // What was commanded before the first row is not known.
        let settled_s = recording.t_s.first().copied().unwrap_or_default() + ACTS_S;
        all.windows.retain(|window| recording.t_s[window.start] >= settled_s);
        Ok(all)
    });
    each.collect()
}
