#![allow(clippy::unwrap_used)]
use super::*;
use crate::decide::Request;
use crate::decide::testing::{machine, recording};
use crate::effects::{Harmonic, VOCABULARY, find};
use crate::refit::{HORIZON_S, Windows};
use crate::screen::{Outcome, Problem, Search};

const RESOLUTION: f64 = std::f64::consts::TAU / 491_520.0;

fn nominal() -> Physics {
    Physics::nominal(&machine())
}

fn prepared(recording: &Recording, machine: &Physics) -> (Problem, Outcome) {
    let problem = Problem::new(vec![Motion::new(recording, machine, RESOLUTION)], 1, machine.clone());
    let outcome = Search::new(&problem, &[], false).run(&[]);
    (problem, outcome)
}

fn path(motion: &Motion) -> Path<'_> {
    Path::of(motion, 0, motion.smooth.len())
}

#[test]
fn a_twin_follows_the_recorded_motion_and_is_the_same_for_the_same_seed() {
    let recorded = recording(&nominal(), 0.05, 3.0, 1);
    let motion = Motion::new(&recorded, &nominal(), RESOLUTION);
    let noise = Noise { torque: 0.05, position: 0.0, resolution: RESOLUTION };
    let make = |seed| twin(&nominal(), 0, &recorded, path(&motion), &noise, seed).unwrap();
    let twin = make(7);
    let apart = twin.position.iter().zip(&recorded.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 0.02, "{apart} rad apart");
    assert_eq!(twin, make(7));
    assert_ne!(twin, make(8));
    let steps = twin.position[500] / RESOLUTION;
    assert!((steps - steps.round()).abs() < 1e-6, "not on a step: {steps}");
}

#[test]
fn a_clean_twin_leaves_nothing_in_the_windows_whatever_its_sensor() {
    let recorded = recording(&nominal(), 0.0, 2.0, 2);
    for latency_s in [0.0, 0.0012, -0.0012] {
        let eccentricity = Some(Harmonic { order: 4.0, sine: 0.002, cosine: 0.001 });
        let machine = Physics { latency_s, eccentricity, ..nominal() };
        let motion = Motion::new(&recorded, &nominal(), RESOLUTION);
        let noise = Noise { torque: 0.0, position: 0.0, resolution: 0.0 };
        let twin = twin(&machine, 0, &recorded, path(&motion), &noise, 1).unwrap();
        let rms = Windows::new(&machine, &[twin], 0, RESOLUTION, HORIZON_S).unwrap().rms();
        assert!(rms < 2e-7, "latency {latency_s} s: {rms:.1e} rad");
    }
}

#[test]
fn the_motion_begins_anew_behind_a_gap() {
    let mut recorded = recording(&nominal(), 0.0, 3.0, 3);
    let gone = 2000..2400;
    let motion = Motion::new(&recorded, &nominal(), RESOLUTION);
    let keep = |values: &[f64]| -> Vec<f64> { [&values[..gone.start], &values[gone.end..]].concat() };
    let (position, speed) = (keep(&motion.smooth), keep(&motion.speed));
    for column in [&mut recorded.t_s, &mut recorded.position, &mut recorded.effort_cmd] {
        *column = keep(column);
    }
    recorded.field_cmd_kv_mm = recorded.field_cmd_kv_mm.map(|field| keep(&field));
    recorded.velocity = recorded.velocity.map(|speed| keep(&speed));
    recorded.mode = None;
    recorded.gaps = vec![gone.start - 1];
    let noise = Noise { torque: 0.0, position: 0.0, resolution: 0.0 };
    let path = Path { position: &position, speed: &speed, period_s: 5e-4 };
    let twin = twin(&nominal(), 0, &recorded, path, &noise, 1).unwrap();
    assert!((twin.position[gone.start] - recorded.position[gone.start]).abs() < 1e-3);
    let apart = twin.position.iter().zip(&recorded.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 0.02, "{apart} rad apart");
}

#[test]
fn torque_noise_is_estimated_and_the_floor_is_what_the_true_machine_leaves() {
    // In the long one no two rows would be neighbours if they were spread evenly.
    for (seed, torque_noise_nm, duration_s) in [(4, 0.05, 6.0), (5, 0.3, 6.0), (6, 0.05, 120.0)] {
        let recorded = [recording(&nominal(), torque_noise_nm, duration_s, seed)];
        let (problem, outcome) = prepared(&recorded[0], &nominal());
        let noise = estimate(&problem, &outcome.fit, &outcome.weights, 0, RESOLUTION);
        assert!((noise.torque / torque_noise_nm - 1.0).abs() < 0.2, "{torque_noise_nm}: {noise:?}");
        assert!(noise.position < 0.3 * RESOLUTION, "{noise:?}");
        let floor = noise_floor(&nominal(), &recorded, &problem.motions, &[noise]).unwrap();
        let windows = Windows::new(&nominal(), &recorded, 0, RESOLUTION, HORIZON_S).unwrap();
        let (above, left) = (floor.under(&windows, 0).unwrap(), windows.rms());
        assert!((above.floor / left - 1.0).abs() < 0.2, "{above:?}, left {left:.2e}");
        assert!(above.least < 1.25 && 0.8 < above.most && above.most < 1.6 * above.least, "{above:?}");
        assert!(!above.exceeded(left, 1.25) && !above.swallows(left, 1.25));
        assert_eq!(floor.under(&windows, 1), None, "no other recording was twinned");
        assert_eq!(floor.warnings, Vec::<String>::new());
    }
}

#[test]
fn a_sensor_noise_that_rest_does_not_show_is_told() {
    let recorded = [recording(&nominal(), 0.02, 4.0, 6)];
    let (problem, _) = prepared(&recorded[0], &nominal());
    let noise = Noise { torque: 0.02, position: 5.0 * RESOLUTION, resolution: RESOLUTION };
    let floor = noise_floor(&nominal(), &recorded, &problem.motions, &[noise]).unwrap();
    assert!(floor.warnings.len() == 1 && floor.warnings[0].contains("at rest"), "{:?}", floor.warnings);
}

#[test]
fn nothing_is_found_in_a_clean_twin_and_what_its_model_lacks_is() {
    let machine = machine();
    let recordings = [recording(&nominal(), 0.05, 4.0, 7)];
    let few: Vec<_> =
        ["coulomb_friction", "viscous_friction", "torque_delay", "inertia"].map(|id| find(id).unwrap()).to_vec();
    let request = Request { machine: &machine, recordings: &recordings, holdout: &[], vocabulary: &few };
    let (problem, outcome) = prepared(&recordings[0], &nominal());
    let noises = [estimate(&problem, &outcome.fit, &outcome.weights, 0, RESOLUTION)];
    let found = falsely_found(
        &request,
        &nominal(),
        &recordings,
        &problem.motions,
        &noises,
        (&[], &std::sync::Arc::new(crate::budget::Budget::default())),
    )
    .unwrap();
    assert_eq!(found, Vec::<&str>::new());
    assert!(VOCABULARY.len() > few.len());
    // The same search on the same recording against a machine that lacks friction.
    let lacking = Physics { coulomb: 0.5, ..nominal() };
    let problem = Problem::new(vec![Motion::new(&recordings[0], &lacking, RESOLUTION)], 1, lacking);
    let first = Search::new(&problem, &few, false).first_step();
    assert_eq!(first.first().map(|trial| trial.effect.id), Some("coulomb_friction"));
}
