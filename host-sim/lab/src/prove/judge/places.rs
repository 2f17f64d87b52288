//! Where in time and in state an answer sees what was concealed.

use conceal::case::FITTED;
use conceal::seal::Truth;

use crate::prove::answer::Answer;

/// An event's place in time: a push in the first recording.
pub(super) fn located(truth: &Truth, answer: &Answer) -> Option<f64> {
    let push = truth.effects.iter().find(|effect| effect.id == "disturbance_pulse")?;
    let value = |id: &str| push.parameters.iter().find(|(name, _)| name == id).map(|(_, value)| *value);
    let start_s = value("start_s")?;
    let end_s = start_s + value("duration_s")?;
    let spans = answer.locations.iter().filter(|span| span.recording.ends_with(FITTED[0]));
    let covered = spans.map(|span| {
        let both = span.end_s.min(end_s) - span.start_s.max(start_s);
        (both / (span.end_s.max(end_s) - span.start_s.min(start_s))).max(0.0)
    });
    Some(covered.fold(0.0, f64::max))
}

/// Channels an effect depends on, by the start of their names.
fn channels(id: &str) -> &'static [&'static str] {
    match id {
        "cogging"
        | "gravity_load"
        | "spring_load"
        | "nonlinear_spring"
        | "friction_over_position"
        | "resolver_eccentricity" => &["position"],
        "viscous_friction" | "stribeck_friction" | "quadratic_drag" | "coulomb_friction" | "friction_asymmetry"
        | "stiction_by_rest" | "presliding" => &["speed", "velocity"],
        "field_gain"
        | "er_strength"
        | "field_slew_limit"
        | "field_leakage"
        | "field_lag"
        | "field_dead_time"
        | "field_lag_asymmetry" => &["field", "since_field"],
        _ => &[],
    }
}

/// Whether the first region of an answer is over a channel that the one concealed effect depends on; none where it depends on none.
pub(super) fn region_right(truth: &Truth, answer: &Answer) -> Option<bool> {
    let [effect] = &truth.effects[..] else { return None };
    let expected = channels(&effect.id);
    let first = answer.regions.first().filter(|_| !expected.is_empty())?;
    Some(expected.iter().any(|channel| first.channel.starts_with(channel)))
}
