//! Recordings of a real machine, read from the shared data; skipped where they are not there.

use std::path::Path;

use lab::decide::{Request, diagnose};
use lab::effects::VOCABULARY;
use lab::read::{Machine, Recording};

#[test]
fn dry_friction_of_the_emps_axis_comes_first_and_within_five_percent() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/emps");
    if !folder.is_dir() {
        println!("skipped: {} is not there", folder.display());
        return;
    }
    let machine = Machine::read(&folder.join("machine.toml")).unwrap();
    let recordings = [Recording::read(&folder.join("train.csv"), None).unwrap()];
    let request = Request { machine: &machine, recordings: &recordings, holdout: &[], vocabulary: &VOCABULARY };
    let answer = diagnose(&request).unwrap().answer;
    let first = &answer.effects[0];
    assert_eq!(first.id, "coulomb_friction", "{answer:?}");
    assert!((first.parameters[0].value / 20.39 - 1.0).abs() < 0.05, "{first:?}");
    let asymmetry = answer.effects.iter().find(|effect| effect.id == "friction_asymmetry").unwrap();
    // Slopes of 166.7 and 240.4 N s/m were published.
    assert!((asymmetry.parameters[1].value / -73.7 - 1.0).abs() < 0.15, "{asymmetry:?}");
}
