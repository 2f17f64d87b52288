//! The judge on independent reference responses and on real machines, where those are at hand.

use std::path::{Path, PathBuf};

use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use diagnosis::pipeline::{Conclusion, diagnose};
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use diagnosis::verdict::Verdict;
use plant::{Command, Er, Model};
use recording::{AxisKind, Machine, Recording};

/// A folder beside the repository; none, with the reason printed, where it is not there.
fn shared(folder: &str) -> Option<PathBuf> {
    let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared").join(folder);
    if found.is_dir() {
        return Some(found);
    }
    // On the machine that lands changes nothing may pass unseen.
    assert!(std::env::var_os("CI").is_none(), "the folder ../shared/{folder} is not there");
    println!("skipped: the folder ../shared/{folder} is not there");
    None
}

/// A reference response with the positions of the servo's resolver.
fn reference(file: &Path) -> Recorded {
    let text = std::fs::read_to_string(file).unwrap();
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let column = |index: usize| rows.iter().map(|row| row[index]).collect::<Vec<f64>>();
    Recorded {
        name: file.file_name().unwrap().to_string_lossy().into_owned(),
        t_s: column(0),
        position: column(3),
        commands: rows.iter().map(|row| Command::new(row[1], row[2])).collect(),
        skipped: vec![false; rows.len()],
        after_gap: vec![false; rows.len()],
    }
}

#[test]
fn nothing_is_missing_below_the_sensors_step_from_a_reference_against_its_own_model() {
    let Some(folder) = shared("reference") else { return };
    let step_rad = std::f64::consts::TAU / 491_520.0;
    for (name, delay_s, dead_s, lag_s) in [
        ("plant_none", 0.005, 0.0, 0.0),
        ("plant_field_dead_5", 0.005, 0.005, 0.0),
        ("plant_field_lag_5", 0.005, 0.0, 0.005),
        ("plant_field_dead_2_lag_3", 0.005, 0.002, 0.003),
        ("plant_no_drive_delay", 0.0, 0.002, 0.003),
    ] {
        let recorded = reference(&folder.join(format!("{name}.csv")));
        let model = Model {
            coulomb: 0.763,
            torque_delay_s: delay_s,
            er: Some(Er::new(0.0704, 0.470, dead_s, lag_s)),
            ..Model::new(0.075)
        };
        let problem = Problem::new(Physics::new(model), vec![recorded], 1, step_rad, false);
        let found = diagnose(&problem, &VOCABULARY).unwrap();
        assert_eq!(found.verdict, Verdict::None, "{name}: {:?} {:?}", found.effects, found.remainder);
    }
}

fn diagnosed(folder: &Path, machine: &str, fitted: &[&str], held: &[&str]) -> Conclusion {
    let machine = Machine::read(&folder.join(machine)).unwrap();
    let read = |name: &&str| Recorded::new(&Recording::read(&folder.join(name), Some(machine.axis.kind)).unwrap());
    let recordings: Vec<Recorded> = fitted.iter().chain(held).map(read).collect();
    let linear = machine.axis.kind == AxisKind::Linear;
    let nominal = Physics::nominal(&machine, &[]);
    let problem = Problem::new(nominal, recordings, fitted.len(), machine.axis.resolution, linear);
    diagnose(&problem, &VOCABULARY).unwrap()
}

fn ids(found: &Conclusion) -> Vec<&'static str> {
    found.effects.iter().map(|effect| effect.effect.id).collect()
}

/// The first value of an effect; none where it is not named.
fn value(found: &Conclusion, id: &str) -> Option<f64> {
    found.effects.iter().find(|effect| effect.effect.id == id).map(|effect| effect.intervals[0].value)
}

fn assert_within(found: &Conclusion, id: &str, low: f64, high: f64) {
    let value = value(found, id).unwrap_or(f64::NAN);
    assert!((low..=high).contains(&value), "{id} {value}, not {low} to {high}: {:?}", found.effects);
}

#[test]
fn a_ball_screw_lacks_coulomb_friction_and_an_offset_or_an_asymmetry() {
    let Some(folder) = shared("data/emps") else { return };
    let found = diagnosed(&folder, "machine.toml", &["train.csv"], &["pulses.csv"]);
    println!("{:?} {:?}", found.verdict, found.effects);
    assert_eq!(ids(&found)[0], "coulomb_friction");
    // Published: 20.39 N.
    assert_within(&found, "coulomb_friction", 20.1, 20.7);
    // An offset with the asymmetry as its equivalent, or the asymmetry where its slope predicts more than an offset can.
    let second =
        found.effects.iter().find(|effect| ["torque_offset", "friction_asymmetry"].contains(&effect.effect.id));
    let second = second.unwrap();
    let listed = second.equivalent.iter().any(|other| other.id == "friction_asymmetry");
    assert!(listed || second.effect.id == "friction_asymmetry", "{:?}", second.equivalent);
    assert!(matches!(found.verdict, Verdict::Partial | Verdict::Named), "{:?}", found.verdict);
}

#[test]
fn a_pendulum_lacks_gravity_and_no_cogging_of_order_one() {
    let Some(folder) = shared("data/dfki") else { return };
    let found = diagnosed(&folder, "heavy_no_gravity.toml", &["ddp.csv", "ilqr.csv"], &["dircol.csv"]);
    println!("{:?} {:?}", found.verdict, found.effects);
    assert_eq!(ids(&found)[0], "gravity_load");
    assert_within(&found, "gravity_load", 3.0, 3.5);
    assert!(!ids(&found).contains(&"cogging"), "{:?}", ids(&found));
}

#[test]
fn somebody_pushes_a_pendulum_once() {
    let Some(folder) = shared("data/dfki") else { return };
    let found = diagnosed(&folder, "heavy_full.toml", &["energy.csv"], &[]);
    println!("{:?} {:?}", found.verdict, found.effects);
    let pushes: Vec<_> = found.effects.iter().filter(|effect| effect.effect.id == "disturbance_pulse").collect();
    assert_eq!(pushes.len(), 1, "{:?}", found.effects);
    // About -15 N m for 0.1 s at 16 s.
    let [start, duration, amplitude] = [0, 1, 2].map(|index| pushes[0].intervals[index].value);
    assert!((start - 16.0).abs() < 0.1 && (0.05..0.2).contains(&duration) && (-20.0..-10.0).contains(&amplitude));
}

#[test]
fn robot_joints_lack_viscous_and_dry_friction() {
    let Some(folder) = shared("data/weigand") else { return };
    // Published: joint 1 viscous 2050 N m s/rad and Coulomb 355 N m, joint 6 459 and 76.1; each to 30 %.
    for (joint, viscous, coulomb) in [("j1", 2050.0, 355.0), ("j6", 459.0, 76.1)] {
        let run = |name: &str| format!("{joint}_{name}.csv");
        let [a, b, c] = ["A", "B", "C"].map(run);
        let found = diagnosed(&folder, &format!("{joint}_no_friction.toml"), &[&a, &b], &[&c]);
        println!("{:?} {:?}", found.verdict, found.effects);
        assert_within(&found, "viscous_friction", 0.7 * viscous, 1.3 * viscous);
        assert_within(&found, "coulomb_friction", 0.7 * coulomb, 1.3 * coulomb);
        for wrong in ["torque_deadband", "torque_saturation", "disturbance_pulse", "inertia", "torque_gain"] {
            assert_eq!(value(&found, wrong), None, "{wrong}: {:?}", found.effects);
        }
    }
}

#[test]
fn a_motor_lacks_cogging_behind_a_filtered_current() {
    let Some(folder) = shared("data/odrive_cogging") else { return };
    let fitted = ["slow2_nocomp_0.csv", "slow2_nocomp_1.csv"];
    let found = diagnosed(&folder, "machine.toml", &fitted, &["slow2_nocomp_2.csv"]);
    println!("{:?} {:?}", found.verdict, found.effects);
    assert!(ids(&found).contains(&"torque_filter"), "{:?}", ids(&found));
    let orders: Vec<f64> = found
        .effects
        .iter()
        .filter(|effect| effect.effect.id == "cogging")
        .map(|effect| effect.intervals[1].value.round())
        .collect();
    // Known from a measurement of their own: 7, 28, 14, 36, 12, largest first.
    assert_eq!(orders.first(), Some(&7.0), "{orders:?}");
    assert!(orders.contains(&28.0) && orders.contains(&14.0), "{orders:?}");
}
