#![allow(clippy::unwrap_used)]

use super::*;

const MACHINE_TEXT: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 0.001\nresolution = 0.0\n[plant]\n\
    inertia = 0.5\ncoulomb = 0.25\ntorque_offset = 0.5\n[[effects]]\nid = \"gravity_load\"\namplitude_nm = 2.0\nphase_rad = 0.5\n";
const LOG: &str = "t_s,position_rad,torque_cmd_nm,seq\n0,0,1,0\n0.001,0.5,2,1\n0.002,1,4,2\n0.003,1.5,-1,3\n";

fn subject(folder: &Path) -> Subject {
    std::fs::write(folder.join("m.toml"), MACHINE_TEXT).unwrap();
    for name in ["a.csv", "b.csv", "c.csv"] {
        std::fs::write(folder.join(name), LOG).unwrap();
    }
    subject_of(folder, "m.toml", &["a.csv", "b.csv"], "c.csv").unwrap()
}

fn changed(change: Change) -> (Subject, Option<Added>) {
    let folder = tempfile::tempdir().unwrap();
    let mut subject = subject(folder.path());
    let added = change.apply(&mut subject).unwrap();
    (subject, added)
}

#[test]
fn each_change_is_of_model_and_recordings_together() {
    let (sign, _) = changed(Change::Sign);
    assert_eq!(sign.fitted[0].numbers("position_").unwrap(), [0.0, -0.5, -1.0, -1.5]);
    assert_eq!(sign.held_out[0].numbers("torque_").unwrap()[3], 1.0);
    assert_eq!((sign.machine.plant.torque_offset, sign.machine.plant.coulomb), (-0.5, 0.25));
    assert_eq!(sign.machine.effects[0].parameters[1].1, -0.5);
    let (units, _) = changed(Change::Units);
    assert_eq!(units.fitted[1].numbers("torque_").unwrap(), [8.0, 16.0, 32.0, -8.0]);
    assert_eq!((units.machine.plant.inertia, units.machine.effects[0].parameters[0].1), (4.0, 16.0));
    assert_eq!(units.machine.effects[0].parameters[1].1, 0.5);
    let (split, _) = changed(Change::Split);
    assert_eq!((split.fitted.len(), split.fitted[1].numbers("t_s").unwrap()), (4, vec![0.002, 0.003]));
    let (half, _) = changed(Change::Decimated);
    assert_eq!(half.fitted[0].numbers("torque_").unwrap(), [1.5, 1.5]);
    assert_eq!(half.fitted[0].numbers("seq").unwrap(), [0.0, 1.0]);
    assert_eq!(half.machine.axis.sample_period_s, 0.002);
}

#[test]
fn an_added_effect_is_what_the_commands_need_beside() {
    let rms = 5.5_f64.sqrt();
    let (offset, added) = changed(Change::Offset);
    let added = added.unwrap();
    assert!((added.by - 0.3 * rms).abs() < 1e-12 && added.nominal == 0.5, "{added:?}");
    assert!((offset.held_out[0].numbers("torque_").unwrap()[0] - (1.0 - 0.3 * rms)).abs() < 1e-12);
    let (viscous, added) = changed(Change::Viscous);
    // The axis moves at 500 rad/s throughout.
    let by = added.unwrap().by;
    assert!((by - 0.3 * rms / 500.0).abs() < 1e-12);
    assert!((viscous.fitted[0].numbers("torque_").unwrap()[1] - (2.0 + 500.0 * by)).abs() < 1e-9);
}

#[test]
fn behind_a_late_drive_the_commands_come_earlier_by_its_delay() {
    let folder = tempfile::tempdir().unwrap();
    let mut subject = subject(folder.path());
    let position = |row: i32| f64::from(row * row);
    let rows: String = (0..40).map(|row| format!("{},{},1,{row}\n", f64::from(row) * 1e-3, position(row))).collect();
    subject.fitted[0] = {
        std::fs::write(folder.path().join("d.csv"), format!("t_s,position_rad,torque_cmd_nm,seq\n{rows}")).unwrap();
        Log::read(&folder.path().join("d.csv")).unwrap()
    };
    subject.machine.plant.torque_delay_s = 2.5e-3;
    let by = Change::Spring.apply(&mut subject).unwrap().unwrap().by;
    // What acts in the row that begins 2.5 rows later: the mean position of it and of the one before.
    let middle = |row: i32| 0.5 * (position(row) + position(row + 1));
    let wanted = 1.0 + by * 0.5 * (middle(12) + middle(13));
    let found = subject.fitted[0].numbers("torque_").unwrap()[10];
    assert!((found - wanted).abs() < 1e-9 * wanted, "{found} {wanted}");
}

fn answer(verdict: &str, id: &str, value: f64) -> Answer {
    let text = format!(
        r#"{{"verdict": "{verdict}", "effects": [{{"id": "{id}", "parameters": [
        {{"id": "offset_nm", "value": {value}, "low": {}, "high": {}}}]}}]}}"#,
        value - 0.1,
        value + 0.1
    );
    serde_json::from_str(&text).unwrap()
}

#[test]
fn an_answer_follows_with_its_verdict_its_names_and_its_values() {
    let of =
        |change, after: &Answer, added| Followed::of("x", change, &answer("named", "torque_offset", 1.0), after, added);
    assert!(of(Change::Order, &answer("named", "torque_offset", 1.1), None).follows);
    assert!(!of(Change::Order, &answer("named", "torque_offset", 1.5), None).follows);
    assert!(!of(Change::Order, &answer("partial", "torque_offset", 1.0), None).follows);
    assert!(!of(Change::Order, &answer("named", "inertia", 1.0), None).follows);
    assert!(of(Change::Sign, &answer("named", "torque_offset", -1.0), None).follows);
    assert!(of(Change::Units, &answer("named", "torque_offset", 8.5), None).follows);
    let added = Added { id: "torque_offset", parameter: "offset_nm", nominal: 0.0, by: 0.5 };
    assert!(of(Change::Offset, &answer("partial", "torque_offset", 1.45), Some(&added)).follows);
    assert!(!of(Change::Offset, &answer("unknown", "torque_offset", 1.45), Some(&added)).follows);
    assert!(!of(Change::Offset, &answer("partial", "torque_offset", 1.0), Some(&added)).follows);
}
