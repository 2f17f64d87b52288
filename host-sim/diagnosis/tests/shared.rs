//! The judge on independent reference responses and on real machines, where those are at hand.
#![allow(clippy::unwrap_used)]

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

#[test]
fn a_ball_screw_lacks_coulomb_friction_and_an_offset_or_an_asymmetry() {
    let Some(folder) = shared("data/emps") else { return };
    let found = diagnosed(&folder, "machine.toml", &["train.csv"], &["pulses.csv"]);
    println!("{:?} {:?}", found.verdict, found.effects);
    let first = &found.effects[0];
    assert_eq!(first.effect.id, "coulomb_friction");
    // Published: 20.39 N.
    assert!(first.intervals[0].value > 19.0 && first.intervals[0].value < 21.0, "{:?}", first.intervals);
    let second = found.effects.iter().find(|effect| effect.effect.id == "torque_offset").unwrap();
    assert!(second.equivalent.iter().any(|other| other.id == "friction_asymmetry"), "{:?}", second.equivalent);
    assert!(matches!(found.verdict, Verdict::Partial | Verdict::Named), "{:?}", found.verdict);
}

#[test]
#[ignore = "minutes on two cores; not run again since the budget of work was lowered"]
fn a_pendulum_lacks_gravity_and_no_cogging_of_order_one() {
    let Some(folder) = shared("data/dfki") else { return };
    let found = diagnosed(&folder, "heavy_no_gravity.toml", &["ddp.csv", "ilqr.csv"], &["dircol.csv"]);
    println!("{:?} {:?}", found.verdict, found.effects);
    assert_eq!(ids(&found)[0], "gravity_load");
    assert!(!ids(&found).contains(&"cogging"), "{:?}", ids(&found));
}

#[test]
#[ignore = "minutes on two cores; not run again since the budget of work was lowered"]
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
    assert!(orders.contains(&7.0) && orders.contains(&28.0), "{orders:?}");
}
