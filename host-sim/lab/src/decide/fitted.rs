//! How well the machine fits, before and after.

use super::Request;
use super::prepare::Searched;
use super::twin::Twins;
use crate::Error;
use crate::effects::Physics;
use crate::read::AxisKind;
use crate::refit::{HORIZON_S, Windows};
use crate::report::FitAnswer;
use crate::screen::Fit;

/// Windows of the nominal and the improved machine; without held-out recordings their share is that of blocks left out.
///
/// # Errors
/// A recording too short for one window.
pub(super) fn fit_answer(
    request: &Request<'_>,
    searched: &Searched,
    nominal: &Physics,
    improved: &Physics,
    twins: &Twins,
) -> Result<FitAnswer, Error> {
    let outcome = &searched.outcome;
    let (fitted, holdout) = searched.recordings.split_at(request.recordings.len());
    let resolution = request.machine.axis.resolution;
    let rms = |physics, recordings, first| {
        Windows::new(physics, recordings, first, resolution, HORIZON_S).map(|windows| windows.rms())
    };
    let (before, after) = (rms(nominal, fitted, 0)?, rms(improved, fitted, 0)?);
    let (heldout_before, heldout_after) = if holdout.is_empty() {
        let share = |fit: &Fit| (fit.heldout_sse() / fit.sse.max(1e-300)).sqrt();
        (before * share(&outcome.nominal), after * share(&outcome.fit))
    } else {
        (rms(nominal, holdout, fitted.len())?, rms(improved, holdout, fitted.len())?)
    };
    let floor = outcome.fit.residual_count();
    let unit = if request.machine.axis.kind == AxisKind::Linear { "m" } else { "rad" };
    Ok(FitAnswer {
        before_rms: before,
        after_rms: after,
        heldout_before_rms: heldout_before,
        heldout_after_rms: heldout_after,
        noise_floor_rms: twins.noise_floor_rms.unwrap_or(after * (floor / outcome.fit.sse.max(floor)).sqrt()),
        excess_explained: explained(outcome.nominal.sse, outcome.fit.sse, floor),
        unit: unit.to_owned(),
        horizon_s: HORIZON_S,
    })
}

/// Share of the excess of a sum of squares over a floor that is gone, 1; 1 where there was none.
pub(crate) fn explained(before: f64, after: f64, floor: f64) -> f64 {
    let excess = before - floor.min(after);
    if excess <= 0.0 { 1.0 } else { (before - after) / excess }
}
