//! Simulate, record, write, read, replay: the same commands to the bit, and what is not the same is found where it is.

use std::fs;

use crate::common::{PERIOD_S, field, paper, setup, shared, true_speed};
use analysis::simulate::{Disturbance, Reference, Setup, record, run};
use er_servo::Config;
use er_servo::experiment::{Experiment, Shape};
use recording::Recording;
use recording::replay::{Replay, replay};

/// A noisy run with a push, that passes through all three modes.
fn eventful(config: Config, seed: u64) -> Recording {
    let setup = Setup {
        disturbances: vec![Disturbance { start_s: 0.6, duration_s: 0.05, torque_nm: 8.0 }],
        sensor_noise_rad: 1e-5,
        torque_noise_nm: 0.05,
        seed,
        ..setup(paper(field(0.002, 0.003)), config)
    };
    let shape = Shape::Steps { amplitude_rad: 0.5, dwell_s: 0.3, seed: 7 };
    let reference = Reference::Experiment(Experiment { shape, duration_s: 2.0 });
    record("run.csv", &run(&setup, reference.positions(PERIOD_S).unwrap()).unwrap())
}

fn through_file(recording: &Recording, name: &str) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    recording.write(&file).unwrap();
    Recording::read(&file, None).unwrap()
}

/// The recording without some of its rows, as a file that lost them; gaps are found anew by the reader.
fn without(recording: &Recording, lost: impl Fn(usize) -> bool) -> Recording {
    fn keep<T: Clone>(values: &[T], lost: &impl Fn(usize) -> bool) -> Vec<T> {
        values.iter().enumerate().filter(|(row, _)| !lost(*row)).map(|(_, value)| value.clone()).collect()
    }
    let r = recording.clone();
    let shorter = Recording {
        t_s: keep(&r.t_s, &lost),
        position: keep(&r.position, &lost),
        effort_cmd: keep(&r.effort_cmd, &lost),
        reference: r.reference.map(|values| keep(&values, &lost)),
        field_cmd_kv_mm: r.field_cmd_kv_mm.map(|values| keep(&values, &lost)),
        mode: r.mode.map(|values| keep(&values, &lost)),
        velocity: r.velocity.map(|values| keep(&values, &lost)),
        seq: r.seq.map(|values| keep(&values, &lost)),
        fault: r.fault.map(|values| keep(&values, &lost)),
        counts: r.counts.map(|values| keep(&values, &lost)),
        ..r
    };
    through_file(&shorter, "run.csv")
}

fn identical(result: &Replay, rows: usize) {
    assert_eq!((&result.difference, result.rows), (&None, rows), "{result}");
}

#[test]
fn a_recording_replays_to_the_bit_through_csv_and_parquet() {
    let recording = eventful(Config::default(), 3);
    let modes = recording.mode.as_ref().unwrap();
    assert!(recording::Mode::ALL.iter().all(|mode| modes.contains(mode)), "all modes occur");
    for name in ["run.csv", "run.parquet"] {
        let result = replay(&through_file(&recording, name), &Config::default()).unwrap();
        assert_eq!(result.to_string(), "identical, 4000 rows");
    }
}

#[test]
fn a_recording_of_the_true_speed_replays_with_the_speed_from_the_converter() {
    let recording = through_file(&eventful(true_speed(), 3), "run.csv");
    assert_eq!(replay(&recording, &true_speed()).unwrap().to_string(), "identical, 4000 rows");
    let other = replay(&recording, &Config { speed_from_converter: false, ..true_speed() }).unwrap();
    assert!(other.difference.is_some());
    let blind = Recording { velocity: None, ..recording };
    assert!(replay(&blind, &true_speed()).is_err(), "the converter's speed cannot be computed from counts");
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_one_does_not() {
    let folder = tempfile::tempdir().unwrap();
    for extension in ["csv", "parquet"] {
        let bytes = |seed: u64, name: &str| {
            let file = folder.path().join(format!("{name}.{extension}"));
            eventful(Config::default(), seed).write(&file).unwrap();
            fs::read(file).unwrap()
        };
        assert_eq!(bytes(5, "a"), bytes(5, "b"));
        assert_ne!(bytes(5, "a"), bytes(6, "b"));
    }
}

#[test]
fn a_changed_gain_is_found_in_the_first_row_where_it_shows() {
    let recording = eventful(Config::default(), 3);
    let other = Config { kp_nm_rad: 240.001, ..Config::default() };
    let difference = replay(&recording, &other).unwrap().difference.unwrap();
    // At the start the reference is where the axis stands: no error, no torque, whatever the gain.
    let first_error = recording.reference.as_ref().unwrap().iter().zip(&recording.position).position(|(r, p)| r != p);
    assert_eq!(Some(difference.row), first_error, "{difference:?}");
    assert_eq!(difference.column, "torque_cmd_nm");
}

#[test]
fn one_bit_of_one_command_is_found_in_its_row() {
    let whole = eventful(Config::default(), 3);
    for (column, row) in [("torque_cmd_nm", 1234_usize), ("field_cmd_kv_mm", 2345), ("mode", 3456)] {
        let mut changed = whole.clone();
        match column {
            "torque_cmd_nm" => changed.effort_cmd[row] = f64::from((changed.effort_cmd[row] as f32).next_up()),
            "field_cmd_kv_mm" => {
                let field = changed.field_cmd_kv_mm.as_mut().unwrap();
                field[row] = f64::from((field[row] as f32).next_up());
            }
            _ => changed.mode.as_mut().unwrap()[row] = recording::Mode::Brake,
        }
        let difference = replay(&through_file(&changed, "run.csv"), &Config::default()).unwrap().difference.unwrap();
        assert_eq!((difference.column, difference.row), (column, row), "{difference:?}");
    }
}

#[test]
fn a_gap_costs_the_comparison_of_the_rows_after_it_and_no_more() {
    let whole = eventful(Config::default(), 3);
    let torn = without(&whole, |row| (900..905).contains(&row) || row == 2000);
    assert_eq!(torn.gaps.len(), 2);
    let result = replay(&torn, &Config::default()).unwrap();
    identical(&result, 3994);
    println!("{result}");
    assert!(result.compared >= 3994 - 2, "{} compared", result.compared);
    // Another law is still found behind the gaps.
    let mut changed = torn.clone();
    changed.effort_cmd[3000] += 0.001;
    assert_eq!(replay(&changed, &Config::default()).unwrap().difference.unwrap().row, 3000);
}

#[test]
fn a_recording_that_begins_in_mid_motion_is_compared_once_the_speed_is_known() {
    let whole = eventful(Config::default(), 3);
    let cut = without(&whole, |row| row < 640);
    let result = replay(&cut, &Config::default()).unwrap();
    identical(&result, 3360);
    assert!(result.compared >= 3359, "{} compared", result.compared);
    let other = Config { kd_nm_s_rad: 6.97, ..Config::default() };
    let difference = replay(&cut, &other).unwrap().difference.unwrap();
    assert!(difference.row < 5, "{difference:?}");
}

#[test]
fn without_the_speed_the_law_is_compared_once_its_filter_has_forgotten() {
    let whole = Recording { velocity: None, ..eventful(Config::default(), 3) };
    assert_eq!(replay(&whole, &Config::default()).unwrap().to_string(), "identical, 4000 rows", "from rest");
    let cut = without(&whole, |row| row < 640 || row == 2000);
    let result = replay(&cut, &Config::default()).unwrap();
    identical(&result, 3359);
    println!("{result}");
    assert!(result.compared >= 3359 - 2 * 60, "{} compared", result.compared);
    let other = Config { kd_nm_s_rad: 6.97, ..Config::default() };
    let difference = replay(&cut, &other).unwrap().difference.unwrap();
    assert!(difference.row < 60, "{difference:?}");
}

#[test]
fn a_fault_and_a_stop_are_not_compared() {
    let mut recording = eventful(Config::default(), 3);
    for row in 1500..1600 {
        recording.fault.as_mut().unwrap()[row] = 4;
        recording.effort_cmd[row] = 0.0;
        recording.field_cmd_kv_mm.as_mut().unwrap()[row] = 0.0;
        recording.mode.as_mut().unwrap()[row] = recording::Mode::Off;
    }
    identical(&replay(&recording, &Config::default()).unwrap(), 4000);
}

#[test]
fn what_cannot_be_replayed_says_so() {
    let recording = eventful(Config::default(), 3);
    let without_reference = Recording { reference: None, ..recording.clone() };
    let error = replay(&without_reference, &Config::default()).unwrap_err();
    assert_eq!(error.to_string(), "run.csv: replay needs the column reference_rad");
    let broken = Config { kp_nm_rad: f32::NAN, ..Config::default() };
    let error = replay(&recording, &broken).unwrap_err();
    assert!(error.to_string().starts_with("run.csv: [controller] kp_nm_rad: NaN"), "{error}");
    if let Some(data) = shared("data") {
        let linear = Recording::read(&data.join("emps/train.csv"), None).unwrap();
        assert!(replay(&linear, &Config::default()).unwrap_err().to_string().contains("rotary"));
    }
}
