//! How well the machine fits, before and after.

use std::borrow::Cow;
use std::rc::Rc;

use super::Request;
use super::prepare::Searched;
use super::twin::{Above, Twins};
use crate::Error;
use crate::effects::Physics;
use crate::read::{AxisKind, Recording};
use crate::refit::{HORIZON_S, Windows};
use crate::report::{EffectAnswer, FitAnswer};
use crate::screen::Fit;

/// The effect that is samples left out.
const GLITCH: &str = "sensor_glitch";

/// What the improved machine leaves of the windows against what noise alone would; none where no twin could be made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Floors {
    /// Of what was fitted.
    pub fitted: Option<Above>,
    /// Of what was held out.
    pub held_out: Option<Above>,
}

/// Windows of the nominal and the improved machine; without held-out recordings their share is that of blocks left out.
/// Isolated wrong samples count against the nominal machine where `effects` name them, and are left out everywhere else.
/// The evidence of that one effect, which no fit has, is given to it here.
///
/// # Errors
/// A recording too short for one window.
// Over 40 lines: nine figures, each named once.
pub(super) fn fit_answer(
    request: &Request<'_>,
    searched: &Searched,
    (nominal, improved): (&Physics, &Physics),
    effects: &mut [EffectAnswer],
    twins: &Twins,
) -> Result<(FitAnswer, Floors), Error> {
    let outcome = &searched.outcome;
    let repaired = repaired(searched);
    let named = effects.iter().any(|effect| effect.id == GLITCH);
    let recorded: &[Recording] = if named { &searched.recordings } else { &repaired };
    let count = request.recordings.len();
    let resolution = request.machine.axis.resolution;
    let windows = |physics, recordings: &[Recording], first| {
        let windows = Windows::new(physics, recordings, first, resolution, HORIZON_S)?;
        searched.problem.budget.spend(windows.work);
        Ok::<_, Error>(windows)
    };
    let rms = |physics, recordings, first| windows(physics, recordings, first).map(|windows| windows.rms());
    let left = match &repaired {
        Cow::Borrowed(_) => searched.windows(request, improved)?,
        Cow::Owned(repaired) => Rc::new(windows(improved, &repaired[..count], 0)?),
    };
    let (before, after) = (rms(nominal, &recorded[..count], 0)?, left.rms());
    let above = |windows: &Windows, first| twins.floor.as_ref().and_then(|floor| floor.under(windows, first));
    let fitted = above(&left, 0);
    let (heldout_before, heldout_after, held_out) = if request.holdout.is_empty() {
        let share = |fit: &Fit| (fit.heldout_sse() / fit.sse.max(1e-300)).sqrt();
        (before * share(&outcome.nominal), after * share(&outcome.fit), fitted)
    } else {
        let left = windows(improved, &repaired[count..], count)?;
        (rms(nominal, &recorded[count..], count)?, left.rms(), above(&left, count))
    };
    if let Some(effect) = effects.iter_mut().find(|effect| effect.id == GLITCH) {
        // On held-out recordings where there are any, else on all.
        let from = if request.holdout.is_empty() { 0 } else { count };
        let left = rms(improved, &repaired[from..], from)? / rms(improved, &recorded[from..], from)?.max(1e-300);
        effect.evidence.heldout_gain = 1.0 - left;
    }
    let floor = outcome.fit.residual_count();
    let balance = (floor / outcome.fit.sse.max(floor)).sqrt();
    // Of the windows, as all other figures here; the torque balance may come down where they hardly do.
    let share = match fitted {
        Some(above) => explained(before * before, after * after, above.floor * above.floor),
        None => explained(outcome.nominal.sse, outcome.fit.sse, floor),
    }
    .clamp(0.0, 1.0);
    for effect in effects.iter_mut() {
        effect.evidence.excess_explained = effect.evidence.excess_explained.min(share);
    }
    let unit = if request.machine.axis.kind == AxisKind::Linear { "m" } else { "rad" };
    let answer = FitAnswer {
        before_rms: before,
        after_rms: after,
        heldout_before_rms: heldout_before,
        heldout_after_rms: heldout_after,
        noise_floor_rms: fitted.map_or(after * balance, |above| above.floor),
        heldout_floor_rms: held_out.map_or(heldout_after * balance, |above| above.floor),
        excess_explained: share,
        unit: unit.to_owned(),
        horizon_s: left.horizon_s(),
    };
    Ok((answer, Floors { fitted, held_out }))
}

/// The recordings without isolated wrong samples.
fn repaired(searched: &Searched) -> Cow<'_, [Recording]> {
    if searched.problem.wrong_samples() == 0 {
        return Cow::Borrowed(&searched.recordings);
    }
    let pairs = searched.recordings.iter().zip(&searched.problem.motions);
    pairs.map(|(recording, motion)| Recording { position: motion.position.clone(), ..recording.clone() }).collect()
}

/// Share of the excess of a sum of squares over a floor that is gone, 1; 1 where there was none.
pub(crate) fn explained(before: f64, after: f64, floor: f64) -> f64 {
    let excess = before - floor.min(after);
    if excess <= 0.0 { 1.0 } else { (before - after) / excess }
}
