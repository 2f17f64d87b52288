//! Residuals of a machine over several recordings.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use crate::Error;
use crate::effects::Physics;
use plant::State;
use rayon::prelude::*;

use super::observer::Observer;
use crate::read::Recording;
use crate::refit::model;
use crate::residual::{Residual, residual_from};
use crate::screen::Motion;

/// Length of the windows that an answer reports, s, where ten rows take no longer.
pub const HORIZON_S: f64 = 0.05;

/// The coarsest sampling that is diagnosed, s: with it a window is half a second, and what a machine does between two rows
/// is no more than a tenth of that.
pub const COARSEST_S: f64 = 0.05;

/// What was commanded before the first row is not known, and acts this long, s.
pub(crate) const SETTLE_S: f64 = 0.03;

/// Short windows of one machine over some recordings.
#[derive(Debug)]
pub struct Windows {
    /// One for each recording.
    pub residuals: Vec<Residual>,
    /// Steps that the simulations took, see [`crate::budget`].
    pub work: u64,
}

impl Windows {
    /// Runs the machine over the recordings in windows of `horizon_s`, or of ten rows where those are longer; the first of them is number `first` of the machine's
    /// pushes and phases. Bristles and loads are sought from where an observer along the recorded motion has them; `resolution`
    /// is the smallest step of the position, rad (m).
    ///
    /// # Errors
    /// A recording too short for one window, or a machine that cannot be simulated.
    pub fn new(
        physics: &Physics,
        recordings: &[Recording],
        first: usize,
        resolution: f64,
        horizon_s: f64,
    ) -> Result<Self, Error> {
        let work = Arc::default();
        let each = recordings.par_iter().enumerate();
        let residuals = each.map(|(index, recording)| {
            let model = model(physics, first + index);
            let inside = if physics.remembers() {
                let rows: Vec<usize> = (0..recording.t_s.len()).collect();
                let motion = Motion::new(recording, physics, resolution);
                Observer::new(&motion).states(physics, &rows)
            } else {
                Vec::new()
            };
            let inside = |row: usize| inside.get(row).copied().unwrap_or_else(State::default);
            let mut all = residual_from(&model, recording, horizon_s, &inside, &work)?;
            let settled_s = recording.t_s[0] + SETTLE_S;
            all.windows.retain(|window| recording.t_s[window.start] >= settled_s);
            Ok(all)
        });
        let residuals = residuals.collect::<Result<_, Error>>()?;
        Ok(Self { residuals, work: work.load(Ordering::Relaxed) })
    }

    /// Length of the windows, s; the longest of all recordings.
    pub fn horizon_s(&self) -> f64 {
        self.residuals.iter().map(|residual| residual.horizon_s).fold(0.0, f64::max)
    }

    /// Root mean square over all samples of all windows, rad (m); 0 without any.
    pub fn rms(&self) -> f64 {
        let (sum, count) = self.residuals.iter().fold((0.0, 0), |(sum, count), residual| {
            let rows: usize = residual.windows.iter().map(|window| window.residual.len()).sum();
            (sum + residual.rms().powi(2) * rows as f64, count + rows)
        });
        if count == 0 { 0.0 } else { (sum / count as f64).sqrt() }
    }
}
