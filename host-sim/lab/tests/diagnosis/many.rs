//! Nothing missing, two things missing, a thing that may not be named, logs that mislead, and motion that cannot tell. Each
//! as a few cases in every run, and as all of them by name:
//! `cargo test --release -p lab --test diagnosis many -- --ignored --nocapture`.

use diagnosis::effects::find;
use diagnosis::physics::Physics;
use er_servo::experiment::Shape;
use lab::read::Recording;
use lab::report::{Answer, Verdict};

use crate::cases::{answer, nominal, recorded, recorded_as};
use crate::singles::CASES;

/// Torque noise, N m.
const NOISE_NM: f64 = 0.05;
/// Length of each recording, s.
const DURATION_S: f32 = 5.0;

/// Pairs with their fitted values.
const PAIRS: [[(&str, &[f64]); 2]; 10] = [
    [("coulomb_friction", &[0.9]), ("field_lag", &[0.007])],
    [("viscous_friction", &[0.1]), ("torque_gain", &[0.95])],
    [("gravity_load", &[0.3, 0.1]), ("er_strength", &[0.88])],
    [("torque_offset", &[0.15]), ("inertia", &[0.080])],
    [("cogging", &[14.0, 0.1, 0.15]), ("coulomb_friction", &[0.65])],
    [("spring_load", &[0.4]), ("torque_delay", &[0.0058])],
    [("friction_asymmetry", &[0.2, 0.0]), ("er_drift", &[-0.03])],
    [("quadratic_drag", &[0.08]), ("field_dead_time", &[0.004])],
    [("vibration", &[17.3, 0.15, 0.1, 0.1, 0.15, 0.18, 0.0]), ("viscous_friction", &[0.1])],
    [("stribeck_friction", &[0.4, 0.1]), ("torque_lag", &[0.001])],
];

/// Effects that one slow sine hardly shows.
const CONFOUNDED: [(&str, &[f64]); 6] = [
    ("coulomb_friction", &[0.95]),
    ("er_strength", &[0.8]),
    ("field_gain", &[0.85]),
    ("inertia", &[0.085]),
    ("torque_gain", &[0.93]),
    ("field_lag", &[0.008]),
];

/// A machine with effects put into it.
fn with(effects: &[(&str, &[f64])]) -> Physics {
    let mut physics = nominal();
    effects.iter().for_each(|(id, values)| (find(id).unwrap().put)(&mut physics, values));
    physics
}

fn ids(answer: &Answer) -> Vec<&str> {
    answer.effects.iter().map(|effect| effect.id.as_str()).collect()
}

fn clean(seeds: std::ops::Range<u64>) {
    let recordings = 3 * (seeds.end - seeds.start);
    let named: Vec<(u64, String)> = seeds
        .filter_map(|seed| {
            let answer = answer(&recorded(&nominal(), seed, NOISE_NM, DURATION_S), "");
            (answer.verdict != Verdict::None).then(|| (seed, format!("{:?} {:?}", answer.verdict, ids(&answer))))
        })
        .collect();
    println!("{recordings} clean recordings, three to a diagnosis; not `none`: {named:?}");
    assert!(named.is_empty(), "{named:?}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn clean_recordings_are_none() {
    clean(200..201);
}

#[test]
#[ignore = "all 51 recordings, minutes: cargo test --release -p lab --test diagnosis many -- --ignored --nocapture"]
fn fifty_clean_recordings_are_none() {
    clean(200..217);
}

fn pairs(every: usize) {
    let mut missed = Vec::new();
    for (index, pair) in PAIRS.iter().enumerate().step_by(every) {
        let answer = answer(&recorded(&with(pair), 300 + index as u64, NOISE_NM, DURATION_S), "");
        let mut found = ids(&answer);
        println!("{} and {}: {:?} {}", pair[0].0, pair[1].0, answer.verdict, found.join(", "));
        found.sort_unstable();
        let mut truth = pair.map(|(id, _)| id);
        truth.sort_unstable();
        if found != truth || answer.verdict == Verdict::Unknown {
            missed.push(pair.map(|(id, _)| id));
        }
    }
    assert!(missed.is_empty(), "{missed:?}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn each_fifth_pair_is_found_exactly() {
    pairs(5);
}

#[test]
#[ignore = "all ten pairs, minutes: cargo test --release -p lab --test diagnosis many -- --ignored --nocapture"]
fn ten_pairs_are_found_exactly() {
    pairs(1);
}

/// Each effect taken out of the vocabulary in turn.
fn removed(every: usize) {
    let mut wrong = Vec::new();
    for (index, (id, sizes)) in CASES.into_iter().enumerate().step_by(every) {
        let answer = answer(&recorded(&with(&[(id, sizes[0])]), 40 + index as u64, NOISE_NM, DURATION_S), id);
        println!("without {id:22} {:?} {}", answer.verdict, ids(&answer).join(", "));
        if answer.verdict == Verdict::Named {
            wrong.push((id, ids(&answer).join(", ")));
        }
    }
    println!("named though it may not be: {wrong:?}");
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn what_may_not_be_named_is_not_named_otherwise() {
    removed(20);
}

#[test]
#[ignore = "all effects, minutes: cargo test --release -p lab --test diagnosis many -- --ignored --nocapture"]
fn no_effect_that_may_not_be_named_is_named_otherwise() {
    removed(1);
}

/// A log that misleads, of the nominal machine and of one with more friction, hides nothing and adds nothing. Uneven time is
/// an arm of `prove`, whose recordings are made with it.
fn misled(name: &str, mislead: fn(&mut Recording)) {
    for truth in [None, Some("coulomb_friction")] {
        let physics = truth.map_or_else(nominal, |id| with(&[(id, &[0.95])]));
        let mut files = recorded(&physics, 400, NOISE_NM, DURATION_S);
        files.iter_mut().for_each(mislead);
        let answer = answer(&files, "");
        println!("{name}, {truth:?}: {:?} {}", answer.verdict, ids(&answer).join(", "));
        assert_eq!(ids(&answer), truth.into_iter().collect::<Vec<_>>(), "{name}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn lost_rows_hide_nothing_and_add_nothing() {
    misled("torn", |file| {
        thin(file, |row| row % 1900 < 1860);
        file.gaps =
            (1..file.t_s.len()).filter(|&row| file.t_s[row] - file.t_s[row - 1] > 0.01).map(|row| row - 1).collect();
    });
}

/// Fewer bits than the machine file has.
#[test]
fn coarse_positions_hide_nothing_and_add_nothing() {
    misled("12 bits", |file| {
        let step = std::f64::consts::TAU / 4096.0;
        file.position.iter_mut().for_each(|q| *q = (*q / step).round() * step);
    });
}

/// Keeps the rows that are asked for.
fn thin(file: &mut Recording, kept: impl Fn(usize) -> bool) {
    let rows: Vec<usize> = (0..file.t_s.len()).filter(|&row| kept(row)).collect();
    fn pick<T: Copy>(column: &mut Vec<T>, rows: &[usize]) {
        *column = rows.iter().map(|&row| column[row]).collect();
    }
    for column in [&mut file.t_s, &mut file.position, &mut file.effort_cmd] {
        pick(column, &rows);
    }
    for column in [&mut file.field_cmd_kv_mm, &mut file.velocity, &mut file.reference].into_iter().flatten() {
        pick(column, &rows);
    }
    file.mode.iter_mut().for_each(|column| pick(column, &rows));
    file.seq = None;
    file.fault = None;
    file.counts = None;
}

fn slow_sine(every: usize) {
    let shape = Shape::Chirp { amplitude_rad: 0.5, from_hz: 0.4, to_hz: 0.4 };
    for (index, (id, values)) in CONFOUNDED.iter().enumerate().step_by(every) {
        let shapes = [shape; 3];
        let files = recorded_as(&with(&[(id, values)]), shapes, 500 + index as u64, NOISE_NM, DURATION_S);
        let answer = answer(&files, "");
        let listed = answer.effects.iter().any(|effect| effect.id == *id || effect.equivalent.iter().any(|e| e == id));
        println!(
            "{id}: {:?} {} listed {listed}, to record next: {}",
            answer.verdict,
            ids(&answer).join(", "),
            answer.experiment.as_ref().map_or("-", |experiment| experiment.text.as_str())
        );
        assert!(listed || answer.verdict != Verdict::Named, "{id}: {:?}", ids(&answer));
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn one_slow_sine_names_nothing_wrongly() {
    slow_sine(3);
}

#[test]
#[ignore = "all of them, minutes: cargo test --release -p lab --test diagnosis many -- --ignored --nocapture"]
fn one_slow_sine_names_none_wrongly() {
    slow_sine(1);
}
