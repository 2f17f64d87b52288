#![allow(clippy::unwrap_used)]
use super::*;

fn answer(verdict: &str, id: &str, equivalent: &str) -> Answer {
    let text = format!(
        r#"{{"schema": 1, "verdict": "{verdict}", "effects": [{{"id": "{id}", "text": "", "equivalent": [{equivalent}],
        "parameters": [{{"id": "phase_rad", "value": 3.1, "low": 3.0, "high": 3.2, "unit": "rad"}}]}}],
        "fit": {{"heldout_after_rms": 1.1, "noise_floor_rms": 1.0}},
        "locations": [{{"recording": "a.csv", "start_s": 1.2, "end_s": 1.4, "share": 0.3, "text": ""}}],
        "regions": [{{"channel": "position_rad", "low": 0, "high": 1, "share": 0.5}}]}}"#
    );
    serde_json::from_str(&text).unwrap()
}

fn judged(arm: Arm, id: &str, parameters: &[(&str, f64)], answer: &Answer) -> Outcome {
    let parameters = parameters.iter().map(|(id, value)| ((*id).to_owned(), *value)).collect();
    let effect = Concealed { id: id.to_owned(), in_vocabulary: true, size: 1.0, strength: 1.0, parameters };
    let effects = if id.is_empty() { Vec::new() } else { vec![effect] };
    let truth = Truth { effects, ..crate::prove::score::testing::truth(arm) };
    Outcome::of(truth, String::new(), answer, 0.0)
}

#[test]
fn a_right_name_counts_and_a_phase_a_turn_away_is_the_same() {
    let right = judged(Arm::Single, "gravity_load", &[("phase_rad", 3.05 - TAU)], &answer("named", "gravity_load", ""));
    assert!(right.is_right() && right.exact && right.first_right && !right.confidently_wrong);
    assert!(right.intervals.iter().all(|interval| interval.holds) && right.intervals.len() == 1);
    assert_eq!((right.region_right, right.heldout_over_floor), (Some(true), Some(1.1)));
    let outside = judged(Arm::Single, "gravity_load", &[("phase_rad", 2.0)], &answer("named", "gravity_load", ""));
    assert!(!outside.intervals[0].holds);
}

#[test]
fn another_order_is_another_cogging() {
    let text = serde_json::to_string(&serde_json::json!({"schema": 1, "verdict": "named", "effects": [{"id": "cogging", "text": "",
        "equivalent": [], "parameters": [{"id": "order_per_rev", "value": 36, "low": 36, "high": 36, "unit": "1/rev"}]}]}))
    .unwrap();
    let answer: Answer = serde_json::from_str(&text).unwrap();
    for (order, is_it) in [(36.0, true), (12.0, false)] {
        let judged = judged(Arm::Single, "cogging", &[("order_per_rev", order)], &answer);
        assert_eq!([judged.exact, judged.first_right, judged.listed, !judged.confidently_wrong], [is_it; 4]);
        assert_eq!(judged.intervals.len(), usize::from(is_it));
    }
}

#[test]
fn another_frequency_is_another_vibration() {
    let parameter = serde_json::json!({"id": "frequency_hz", "value": 2.8, "low": 2.7, "high": 2.9, "unit": "Hz"});
    let answer = of_parameter("vibration", &parameter);
    for (frequency_hz, is_it) in [(2.81, true), (18.2, false)] {
        let judged = judged(Arm::Single, "vibration", &[("frequency_hz", frequency_hz)], &answer);
        assert_eq!([judged.exact, judged.first_right, !judged.confidently_wrong], [is_it; 3]);
    }
}

#[test]
fn a_wrong_first_name_is_confident_where_it_is_named_and_counts_apart_where_it_is_partial() {
    let wrong = judged(Arm::Single, "inertia", &[], &answer("named", "torque_gain", ""));
    assert!(wrong.confidently_wrong && !wrong.listed && !wrong.is_right());
    let hedged = judged(Arm::Single, "inertia", &[], &answer("named", "torque_gain", "\"inertia\""));
    assert!(hedged.confidently_wrong && hedged.listed && !hedged.first_right);
    let partial = judged(Arm::Single, "inertia", &[], &answer("partial", "torque_gain", ""));
    assert!(!partial.confidently_wrong && partial.partial_wrong && !partial.is_right());
    let ambiguous = judged(Arm::Single, "inertia", &[], &answer("ambiguous", "torque_gain", "\"inertia\""));
    assert!(!ambiguous.confidently_wrong && !ambiguous.is_right());
    assert!(judged(Arm::Poor, "inertia", &[], &answer("ambiguous", "torque_gain", "\"inertia\"")).is_right());
}

#[test]
fn outside_the_library_any_plain_name_is_wrong_and_unknown_is_right() {
    let named = judged(Arm::Outside, "torque_memory", &[], &answer("named", "torque_gain", ""));
    assert!(named.confidently_wrong && !named.abstained_right);
    assert!(judged(Arm::Outside, "torque_memory", &[], &answer("unknown", "torque_gain", "")).is_right());
    assert!(judged(Arm::Clean, "", &[], &answer("named", "torque_gain", "")).confidently_wrong);
    assert!(judged(Arm::Clean, "", &[], &answer("none", "torque_gain", "")).is_right());
    assert!(judged(Arm::Decoy, "", &[], &answer("none", "torque_gain", "")).is_right());
    assert!(judged(Arm::Decoy, "inertia", &[], &answer("named", "inertia", "")).is_right());
    assert!(judged(Arm::Controller, "", &[], &answer("controller", "torque_gain", "")).is_right());
}

#[test]
fn a_twin_of_the_name_taken_out_is_wrong_and_counted_apart() {
    let removed = |named: &str| judged(Arm::Removed, "torque_offset", &[], &answer("named", named, ""));
    let (twin, other) = (removed("friction_asymmetry"), removed("gravity_load"));
    assert_eq!([twin.confidently_wrong, other.confidently_wrong], [true; 2]);
    assert_eq!([twin.wrong_indistinct, other.wrong_indistinct], [true, false]);
}

#[test]
fn a_push_is_located_by_the_share_that_both_spans_cover() {
    let push = |start_s| {
        let values = [("start_s", start_s), ("duration_s", 0.1)];
        judged(Arm::Single, "disturbance_pulse", &values, &answer("named", "disturbance_pulse", "")).located.unwrap()
    };
    assert!((push(1.15) - 0.05 / 0.25).abs() < 1e-9 && push(2.0) == 0.0 && (push(1.3) - 0.5).abs() < 1e-9);
}

#[test]
fn after_the_experiment_only_named_and_exact_is_right() {
    let truth = judged(Arm::Poor, "inertia", &[], &answer("none", "inertia", "")).truth;
    assert!(After::of(&truth, &answer("named", "inertia", "")).right);
    assert!(!After::of(&truth, &answer("ambiguous", "inertia", "")).right);
    assert!(After::of(&truth, &answer("named", "torque_gain", "")).confidently_wrong);
}

fn cogging(order: f64) -> Answer {
    of_order("cogging", order)
}

fn of_order(id: &str, order: f64) -> Answer {
    of_parameter(id, &serde_json::json!({"id": "order_per_rev", "value": order, "low": order, "high": order}))
}

fn of_parameter(id: &str, parameter: &serde_json::Value) -> Answer {
    let effect = serde_json::json!({"id": id, "parameters": [parameter]});
    serde_json::from_value(serde_json::json!({"verdict": "named", "effects": [effect]})).unwrap()
}

/// The truth of a drawn machine of an arm, with a ripple or a skew in its log.
fn drawn(arm: Arm, beside: &[&str], ripple_order: Option<f64>) -> Truth {
    let machine = conceal::seal::MachineTruth {
        linear: false,
        period_s: 1e-3,
        inertia: 1.0,
        torque_rms: 1.0,
        speed_rms: 1.0,
        travel: 1.0,
        step: 1e-4,
        fluid: false,
        flashed_law: false,
        measured_torque: false,
        skew_s: 0.0,
        families: Vec::new(),
        beside: beside.iter().map(|id| (*id).to_owned()).collect(),
        ripple_order,
    };
    Truth { machine: Some(machine), ..crate::prove::score::testing::truth(arm) }
}

fn concealed(id: &str, parameters: &[(&str, f64)]) -> Concealed {
    let parameters = parameters.iter().map(|(id, value)| ((*id).to_owned(), *value)).collect();
    Concealed { id: id.to_owned(), in_vocabulary: true, size: 4.0, strength: 1.0, parameters }
}

#[test]
fn a_kind_that_has_a_name_since_is_not_wrongly_named_at_its_order() {
    let truth = |id: &str| Truth {
        effects: vec![concealed(id, &[("share", 0.1), ("order", 37.0)])],
        ..drawn(Arm::Outside, &[], None)
    };
    let of = |kind: &str, answer: &Answer| Outcome::of(truth(kind), String::new(), answer, 0.0);
    assert!(!of("torque_ripple", &of_order("torque_ripple", 37.0)).confidently_wrong);
    assert!(of("torque_ripple", &of_order("torque_ripple", 12.0)).confidently_wrong);
    assert!(of("torque_ripple", &cogging(37.0)).confidently_wrong);
    assert!(!of("friction_by_load", &answer("named", "load_dependent_friction", "")).confidently_wrong);
    // With its own name taken out, nothing is there to be named.
    let removed = Truth { arm: Arm::Removed, ..truth("torque_ripple") };
    assert!(Outcome::of(removed, String::new(), &of_order("torque_ripple", 37.0), 0.0).confidently_wrong);
}

#[test]
fn the_ripple_of_the_noise_is_a_cogging_of_its_own_order_only() {
    let of = |answer: &Answer| Outcome::of(drawn(Arm::Clean, &["cogging"], Some(36.0)), String::new(), answer, 0.0);
    let ripple = of(&cogging(36.0));
    // The strict count says that something was named; the one beside it that nothing was named wrongly.
    assert!(ripple.offers_names() && !ripple.wrongly_named && !ripple.confidently_wrong && ripple.abstained_right);
    let other = of(&cogging(12.0));
    assert!(other.wrongly_named && other.confidently_wrong && !other.abstained_right);
    assert!(
        of(&answer("partial", "inertia", "")).wrongly_named && !of(&answer("unknown", "inertia", "")).wrongly_named
    );
}

#[test]
fn what_no_motion_tells_apart_counts_beside_the_strict_figure() {
    let truth = Truth { effects: vec![concealed("sensor_latency", &[])], ..drawn(Arm::Single, &[], None) };
    let of = |id: &str| Outcome::of(truth.clone(), String::new(), &answer("named", id, ""), 0.0);
    assert_eq!([of("sensor_latency").first_right, of("sensor_latency").first_indistinct], [true, true]);
    assert_eq!([of("torque_delay").first_right, of("torque_delay").first_indistinct], [false, true]);
    assert_eq!([of("torque_lag").first_right, of("torque_lag").first_indistinct], [false, false]);
}
