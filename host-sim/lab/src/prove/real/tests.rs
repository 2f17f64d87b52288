#![allow(clippy::unwrap_used)]

use super::least_squares::fitted;
use super::sets::MODELS;
use super::windows::Simulated;
use super::*;
use crate::read::{AxisKind, EffectEntry};

const NOMINAL: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 0.001\nresolution = 0.0\n[plant]\n\
                       inertia = 0.1\n";

fn machine() -> Machine {
    Machine::from_bytes(Path::new("machine.toml"), NOMINAL.as_bytes()).unwrap()
}

/// A pendulum that the examiner's physics swings.
fn pendulum(truth: &Machine) -> Recording {
    use conceal::physics::Physics;
    use conceal::rotor::{Command, Rotor};
    let mut physics = Physics::nominal();
    physics.inertia_kg_m2 = truth.plant.inertia;
    (physics.friction.coulomb_nm, physics.friction.viscous_nm_s_rad) = (truth.plant.coulomb, truth.plant.viscous);
    (physics.drive.delay_s, physics.drive.offset_nm) = (0.0, truth.plant.torque_offset);
    physics.gravity = Some((1.5, 0.2));
    let mut rotor = Rotor::new(&physics, 2e-5);
    let mut recording = Recording::empty(AxisKind::Rotary);
    for row in 0..8000 {
        let t_s = f64::from(row) * 1e-3;
        let torque_nm = 2.0 * (3.0 * t_s).sin() + 1.5 * (7.0 * t_s + 1.0).sin();
        recording.t_s.push(t_s);
        recording.position.push(rotor.position_rad());
        recording.effort_cmd.push(torque_nm);
        let command = Command { torque_nm, ..Command::default() };
        (0..50).for_each(|_| rotor.step(&command));
    }
    recording
}

#[test]
fn least_squares_finds_a_pendulum_and_the_true_model_leaves_nothing_in_windows() {
    let mut truth = machine();
    (truth.plant.coulomb, truth.plant.viscous, truth.plant.torque_offset) = (0.3, 0.1, 0.05);
    let recording = pendulum(&truth);
    let found = fitted(&machine(), &[&recording]).unwrap();
    println!("{:?} {:?}", found.plant, found.effects);
    assert!((found.plant.inertia - 0.1).abs() < 0.005 && (found.plant.coulomb - 0.3).abs() < 0.03);
    assert!((found.plant.viscous - 0.1).abs() < 0.02 && (found.plant.torque_offset - 0.05).abs() < 0.02);
    assert!((found.effects[0].parameters[0].1 - 1.5).abs() < 0.05);
    let parameters = vec![("amplitude_nm".to_owned(), 1.5), ("phase_rad".to_owned(), 0.2)];
    truth.effects.push(EffectEntry { id: "gravity_load".to_owned(), recording: None, parameters });
    let left = |machine: &Machine| Simulated::of(machine).left(&recording, 0.2).unwrap();
    let (best, fitted, nominal) = (left(&truth), left(&found), left(&machine()));
    println!("left: true {best:e}, least squares {fitted:e}, nominal {nominal:e} rad");
    assert!(best < 1e-4 && fitted < 0.1 * nominal && best < fitted, "{best} {fitted} {nominal}");
}

#[test]
fn every_set_has_every_machine_file_and_one_row_in_the_table() {
    let files: std::collections::BTreeSet<(&str, &str)> =
        MODELS.iter().map(|model| (model.folder, model.file)).collect();
    assert_eq!(files.len(), 12, "{files:?}");
    // Each known effect hidden alone, and none of them.
    for (folder, hidden) in [
        ("emps", ["nothing", "dry friction", "viscous friction", "offset"].as_slice()),
        ("odrive_cogging", &["nothing", "cogging"]),
        ("dfki", &["nothing", "gravity", "dry friction", "viscous friction"]),
        ("weigand", &["nothing", "dry friction", "viscous friction", "offset"]),
    ] {
        for hidden in hidden {
            let of = |model: &&super::sets::Model| model.folder == folder && model.hidden == *hidden;
            assert_eq!(MODELS.iter().filter(of).count(), if folder == "weigand" { 2 } else { 1 }, "{folder} {hidden}");
        }
    }
    let fold = |verdict, name: &str, value: f64| Fold {
        held_out: "a.csv".to_owned(),
        verdict,
        named: vec![name.to_owned()],
        answered: vec![Some([value, value - 1.0, value + 1.0])],
        left: [[Some(2.0), Some(1.0), Some(0.5)]; 2],
        without: std::collections::BTreeSet::new(),
        seconds: 1.0,
    };
    let folds = vec![
        fold(Verdict::Named, "coulomb_friction", 20.0),
        fold(Verdict::Partial, "coulomb_friction", 21.0),
        Fold { answered: vec![None], ..fold(Verdict::Partial, "torque_deadband", 0.0) },
    ];
    let known = vec![("coulomb_friction.coulomb_n".to_owned(), [20.39, 20.39], "a paper".to_owned())];
    let mut outcome = RealOutcome { name: "emps/machine".to_owned(), hidden: "dry friction".to_owned(), known, folds };
    let (_, rows) = table(std::slice::from_ref(&outcome));
    assert_eq!(rows[0][2..4], ["partial 2, named 1", "coulomb_friction 2, torque_deadband 1"]);
    assert_eq!(rows[0][4], "coulomb_friction.coulomb_n 20.39: 2 of 3: 20.0000 to 21.0000");
    assert_eq!(rows[0][5..], ["0.500, 0.250", "0.500, 0.250"]);
    outcome.folds[1].without.insert("vibration".to_owned());
    assert_eq!(table(&[outcome]).1[0][5], "0.500 (without vibration), 0.250");
}

#[test]
fn of_several_orders_the_one_that_is_meant_is_found() {
    let answer = r#"{"verdict": "named", "effects": [
        {"id": "cogging", "parameters": [{"id": "order_per_rev", "value": 7.05, "low": 7, "high": 7.1}]},
        {"id": "cogging", "parameters": [{"id": "order_per_rev", "value": 28, "low": 28, "high": 28}]}]}"#;
    let answer: Answer = serde_json::from_str(answer).unwrap();
    let order = |order: f64| estimate(&answer, &("cogging", "order_per_rev", [order, order], ""));
    assert_eq!(order(28.0), Some([28.0, 28.0, 28.0]));
    assert!(order(7.0).is_some() && order(14.0).is_none());
}
