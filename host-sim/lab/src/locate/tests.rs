#![allow(clippy::unwrap_used)]
use crate::decide::testing::{machine, recording};
use crate::effects::{Harmonic, Physics, Pulse};
use crate::locate::{first_unexplained, locations, regions};
use crate::read::AxisKind;
use crate::screen::{Fit, Motion, Problem, Search};

/// A recording of a machine with something the nominal one lacks, judged by the nominal one.
fn judged(change: impl Fn(&mut Physics), seed: u64) -> (Problem, Fit) {
    let machine = machine();
    let nominal = Physics::nominal(&machine);
    let mut truth = nominal.clone();
    change(&mut truth);
    let recorded = recording(&truth, 0.03, 6.0, seed);
    let motion = Motion::new(&recorded, &nominal, machine.axis.resolution);
    let problem = Problem::new(vec![motion], 1, nominal);
    let outcome = Search::new(&problem, &[], false).run(&[]);
    (problem, outcome.nominal)
}

#[test]
fn a_push_is_one_span_and_its_start_the_first_sample_that_cannot_be_explained() {
    for start_s in [1.1, 2.1, 3.1, 4.1] {
        let push = Pulse { recording: 0, start_s, duration_s: 0.06, amplitude: 3.0 };
        let (problem, fit) = judged(|machine| machine.pulses.push(push), 1);
        let regions = regions(&problem, &fit, AxisKind::Rotary);
        let locations = locations(&problem, &fit, AxisKind::Rotary, &regions);
        let first = &locations[0];
        assert!(first.share > 0.9 && first.share_low <= first.share && first.share <= first.share_high, "{first:?}");
        let inside = |at_s: f64| (start_s - 0.03..start_s + 0.13).contains(&at_s);
        assert!(inside(first.start_s) && inside(first.end_s) && first.text.starts_with("once, "), "{first:?}");
        let unexplained = &first_unexplained(&problem, &fit)[0];
        // Rows do not touch rest: a push that meets the rotor there shows when it moves.
        assert!((unexplained.t_s - start_s - 0.008).abs() < 0.0125, "{unexplained:?} for {start_s} s");
    }
}

#[test]
fn a_slow_fall_of_the_field_shows_just_after_it_falls() {
    let slow = |machine: &mut Physics| machine.damper.as_mut().unwrap().fall_s = 0.015;
    let (problem, fit) = judged(slow, 2);
    let regions = regions(&problem, &fit, AxisKind::Rotary);
    let since = regions.iter().find(|region| region.channel == "since_field_step_s").unwrap();
    assert!(since.low < 0.01 && since.high < 0.08 && since.share > 0.7, "{regions:?}");
    let locations = locations(&problem, &fit, AxisKind::Rotary, &regions);
    assert!(locations.iter().any(|location| location.text.contains("field falls")), "{locations:?}");
}

#[test]
fn friction_of_one_direction_and_cogging_show_in_their_channels() {
    let (problem, fit) = judged(|machine| (machine.asymmetry, machine.coulomb) = (0.4, 0.763 + 0.2), 3);
    let one_way = regions(&problem, &fit, AxisKind::Rotary);
    let direction = one_way.iter().find(|region| region.channel == "direction").unwrap();
    assert!(direction.low > 0.0 && direction.share_low > 0.8, "{one_way:?}");
    let teeth = Harmonic { order: 36.0, sine: 0.4, cosine: 0.0 };
    let (problem, fit) = judged(|machine| machine.cogging.push(teeth), 4);
    let regions = regions(&problem, &fit, AxisKind::Rotary);
    assert!(regions.iter().any(|region| region.channel == "phase_of_order_36_rad"), "{regions:?}");
}

#[test]
fn noise_is_nowhere() {
    let (problem, fit) = judged(|_| (), 5);
    assert_eq!(locations(&problem, &fit, AxisKind::Rotary, &[]), []);
    assert_eq!(first_unexplained(&problem, &fit), []);
}
