//! None, named, ambiguous or unknown; and what the user should know before believing it.

use super::checks::neutral;
use super::fitted::{Floors, explained};
use super::prepare::Searched;
use super::twin::Twins;
use crate::effects::{Physics, find};
use crate::locate::Leftover;
use crate::report::{Answer, EffectAnswer, FitAnswer, Verdict};
use crate::screen::{Active, MIN_GAIN};

/// Share of the excess that a model must explain to be named: substitutes explain 0.5 in the median and 0.8 at the 95th
/// percentile (diagnosis.md).
const EXPLAINS: f64 = 0.85;
/// A substitute can come close where the effect is large. What is left far above the noise, in mean squares of it,
const FAR: f64 = 3.0;
/// is only the roughness of a real machine if it is this small a share of what there was: a hard limit in the place of a soft
/// one, or a sensor's error in the place of an inertia, leave 0.006.
const WHOLE: f64 = 0.995;
/// The windows of a true model come down to their floor; this many times the floor is something else on a rough machine,
const OVER_FLOOR: f64 = 3.0;
/// and this many times where the torque balance leaves no roughness, or the model has a memory to come down with.
const OVER_SMOOTH_FLOOR: f64 = 1.45;
/// Above this many times the floor something is left: the roughness of a real machine, or what a substitute misses.
const LEFT: f64 = 1.25;
/// It is roughness where the residual of the torque balance is more than this many times its noise, in mean squares, too;
const ROUGH: f64 = 4.0;
/// and a substitute's where it is this share of what the weakest effect explains in the windows.
const COMPARABLE: f64 = 0.45;
/// A floor this many times what the recording leaves was made from noise that is none.
const SWALLOWED: f64 = 1.8;
/// Held-out gain by the means over a channel of state: the true model leaves less of the residual to predict.
const PREDICTABLE: f64 = 0.15;
/// A model whose windows leave this many times what the nominal one leaves has gone astray.
const ASTRAY: f64 = 1.1;
/// An effect that lowers the held-out error by less does not make the whole answer uncertain where it has equivalents.
const MINOR: f64 = 0.1;

/// The verdict where the controller is right or not known; `reasons` speak against any name.
pub(super) fn verdict(
    searched: &Searched,
    answer: &Answer,
    left: &Leftover,
    (twins, floors): (&Twins, &Floors),
    reasons: &[String],
) -> Verdict {
    if !reasons.is_empty() || is_unknown(searched, answer, left, floors) {
        return Verdict::Unknown;
    }
    let uncertain = |effect: &EffectAnswer| {
        // What is also found where nothing is missing may be the tool's own making.
        let phantom = twins.falsely_found.contains(&effect.id.as_str());
        phantom || !effect.equivalent.is_empty() && effect.evidence.heldout_gain > MINOR
    };
    match answer.effects.as_slice() {
        [] => Verdict::None,
        effects if effects.iter().any(uncertain) => Verdict::Ambiguous,
        _ => Verdict::Named,
    }
}

/// Whether something is left that the best model should have explained.
fn is_unknown(searched: &Searched, answer: &Answer, left: &Leftover, floors: &Floors) -> bool {
    let (outcome, fit) = (&searched.outcome, &answer.fit);
    let active = &outcome.fit.active;
    let memory = searched.problem.machine(active).remembers();
    let held_out_rms = fit.heldout_after_rms;
    let smooth = memory || left.excess < ROUGH && !active.is_empty();
    // Standstill tells nothing in the weak form, and may tell all in the windows. The floor of a recording is made by a few of
    // its windows, so what was held out must be above that of what was fitted too.
    let fitted = fit.noise_floor_rms;
    let above_floor = match smooth {
        true => floors.held_out.is_some_and(|above| {
            above.exceeded(held_out_rms, OVER_SMOOTH_FLOOR) && held_out_rms > OVER_SMOOTH_FLOOR * fitted
        }),
        false => floors.fitted.is_some_and(|above| above.exceeded(fit.after_rms, OVER_FLOOR)),
    };
    // A twin that scatters far more than the recording was given as noise what is none; of a machine with a memory it may
    // scatter because its windows start from a state that is known less well.
    let least = fit.after_rms.min(held_out_rms);
    let swallowed = !memory && floors.fitted.is_some_and(|above| above.swallows(least, SWALLOWED));
    if active.is_empty() {
        // Far above the noise is something, even where no channel of state predicts it.
        return above_floor || swallowed || left.excess > 2.5 || left.gain >= MIN_GAIN && left.excess > 1.5;
    }
    let explains = explained(outcome.nominal.sse, outcome.fit.sse, outcome.fit.residual_count());
    let windows_left = floors.held_out.is_none_or(|above| above.exceeded(held_out_rms, LEFT));
    // The bumps filter the motion of a load, and blur its impacts: there the windows are the witness.
    let rough = if memory { windows_left } else { explains < WHOLE };
    let poor = explains < EXPLAINS || left.excess > FAR && rough;
    // What is below the noise and not seen in the windows is the bumps' own.
    let predictable = left.gain > PREDICTABLE && (left.excess > 1.0 || windows_left);
    // The bumps blur what a load does, so that there the windows must say so too.
    let windows_above = || floors.fitted.is_some_and(|above| above.exceeded(fit.after_rms, LEFT));
    let substitute = match memory {
        true => predictable && windows_above(),
        false => predictable || left.excess < ROUGH && comparable(&answer.effects, fit, floors),
    };
    // What predicts the torque balance and drives the simulation off is not how the machine moves.
    let astray = fit.after_rms > ASTRAY * fit.before_rms || held_out_rms > ASTRAY * fit.heldout_before_rms;
    poor || astray || substitute || above_floor || swallowed
}

/// Whether what the windows have above their floor is as much as the weakest effect explains in them.
fn comparable(effects: &[EffectAnswer], fit: &FitAnswer, floors: &Floors) -> bool {
    let Some(above) = floors.fitted.filter(|above| above.exceeded(fit.after_rms, LEFT)) else { return false };
    let weakest = effects.iter().map(|effect| effect.evidence.heldout_gain).fold(1.0, f64::min);
    // Without it the error would be larger by one over what is left of it.
    let explained = fit.after_rms * ((1.0 - weakest.clamp(0.0, 0.999_999)).powi(-2) - 1.0).sqrt();
    (fit.after_rms.powi(2) - above.floor.powi(2)).sqrt() > COMPARABLE * explained
}

/// In words, which effects have a value that stands where the search ends, in the torque balance or as simulation leaves it:
/// it belongs to something else that pushes it there.
pub(super) fn at_bound(found: &[Active], refined: &[Active]) -> Vec<String> {
    let mut ids: Vec<&str> =
        found.iter().chain(refined).filter(|entry| entry.at_bound()).map(|entry| entry.effect.id).collect();
    ids.sort_unstable();
    ids.dedup();
    ids.into_iter().map(|id| format!("{id}: a value stands at the bound of what was searched")).collect()
}

/// Parameters that say where or how fast an effect acts and not how strong it is.
const PLACES: [&str; 8] = [
    "order_per_rev",
    "order_rad_m",
    "phase_rad",
    "velocity_rad_s",
    "velocity_m_s",
    "frequency_hz",
    "start_s",
    "duration_s",
];

/// In words, which effects may be as strong as they are in the nominal machine: the intervals of all that says how strong
/// they are hold its values, so these recordings do not tell that anything is missing there.
pub(super) fn not_told(effects: &[EffectAnswer], nominal: &Physics, recordings: usize) -> Vec<String> {
    let not_told = effects.iter().filter(|answer| {
        let Some(effect) = find(&answer.id) else { return false };
        let Some(neutral) = neutral(effect, nominal, recordings) else { return false };
        let pairs = answer.parameters.iter().zip((effect.report)(&neutral));
        let mut strengths = pairs.filter(|(p, _)| !PLACES.contains(&p.id.as_str())).peekable();
        strengths.peek().is_some() && strengths.all(|(p, nominal)| p.low <= nominal && nominal <= p.high)
    });
    not_told.map(|answer| format!("{}: its interval holds the nominal value, so it may be none", answer.id)).collect()
}

/// What the user should know before believing the answer.
pub(super) fn warnings(searched: &Searched, left: &Leftover, verdict: Verdict) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Some(filter_s) = searched.effort_filter_s {
        warnings.push(format!(
            "the recorded torque is no command: it follows what acted as if measured behind a filter of {filter_s:.3} s, and \
             was corrected for that"
        ));
    }
    if left.excess > FAR && verdict != Verdict::Unknown {
        warnings.push(format!(
            "{:.1} times the estimated noise is still left after the best model, most of it over {}",
            left.excess.sqrt(),
            if left.channel.is_empty() { "no channel of state" } else { &left.channel }
        ));
    }
    let repaired = searched.problem.wrong_samples();
    if repaired > 0 {
        warnings.push(format!("{repaired} isolated wrong position samples were left out"));
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decide::testing::machine;
    use crate::report::{Evidence, Interval};

    fn answer(id: &str, intervals: &[(&str, f64, f64)]) -> EffectAnswer {
        let parameters = intervals.iter().map(|&(id, low, high)| Interval {
            id: id.to_owned(),
            value: 0.5 * (low + high),
            low,
            high,
            unit: String::new(),
        });
        EffectAnswer {
            id: id.to_owned(),
            text: String::new(),
            equivalent: Vec::new(),
            parameters: parameters.collect(),
            evidence: Evidence { heldout_gain: 0.5, p_value: 0.0, excess_explained: 0.9 },
            recording: None,
        }
    }

    #[test]
    fn an_interval_that_holds_the_nominal_value_tells_nothing() {
        let of = |answer| not_told(&[answer], &Physics::nominal(&machine()), 1).len();
        assert_eq!(of(answer("torque_offset", &[("offset_nm", -10.0, 13.0)])), 1);
        assert_eq!(of(answer("torque_offset", &[("offset_nm", 0.1, 13.0)])), 0);
        let asymmetry = |slope| [("difference_nm", -0.1, 0.1), ("viscous_difference_nm_s_rad", slope, 1.0)];
        assert_eq!(of(answer("friction_asymmetry", &asymmetry(-1.0))), 1);
        assert_eq!(of(answer("friction_asymmetry", &asymmetry(0.5))), 0, "the slopes differ surely");
        let cogging = |low| [("amplitude_nm", low, 0.4), ("order_per_rev", 7.0, 7.0), ("phase_rad", -3.0, 3.0)];
        assert_eq!((of(answer("cogging", &cogging(0.0))), of(answer("cogging", &cogging(0.1)))), (1, 0));
    }
}
