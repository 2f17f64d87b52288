//! Recordings of a real machine, read from the shared data; skipped where they are not there.

use std::path::Path;

use diagnosis::effects::VOCABULARY;
use lab::conclude::{Request, diagnose};
use lab::read::{Machine, Recording};
use lab::report::Answer;

/// The published model has an offset of 3.165 N and no asymmetry, which explains the same.
#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation; the tests in release run it")]
fn without_an_asymmetry_the_emps_axis_has_the_published_offset() {
    let Some(answer) = diagnosed("emps", &["train.csv"], &["pulses.csv"], "friction_asymmetry") else { return };
    let first = &answer.effects[0];
    assert_eq!(first.id, "coulomb_friction", "{answer:?}");
    assert!((first.parameters[0].value / 20.39 - 1.0).abs() < 0.05, "{first:?}");
    let offset = answer.effects.iter().find(|effect| effect.id == "torque_offset").unwrap();
    let value = &offset.parameters[0];
    assert!(value.low < 3.165 && 3.165 < value.high, "{offset:?}");
    let fit = &answer.fit;
    let excess = |rms: f64| rms.powi(2) - fit.heldout_floor_rms.powi(2);
    assert!(excess(fit.heldout_after_rms) < 0.3 * excess(fit.heldout_before_rms), "{fit:?}");
}

/// The answer on recordings of a folder of the shared data; none, with the reason printed, where it is not there.
fn diagnosed(folder: &str, fit: &[&str], holdout: &[&str], without: &str) -> Option<Answer> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(folder);
    if !folder.is_dir() {
        println!("skipped: {} is not there", folder.display());
        return None;
    }
    let machine = Machine::read(&folder.join("machine.toml")).unwrap();
    let read = |names: &[&str]| -> Vec<Recording> {
        names.iter().map(|name| Recording::read(&folder.join(name), None).unwrap()).collect()
    };
    let (recordings, holdout) = (read(fit), read(holdout));
    let vocabulary: Vec<_> = VOCABULARY.iter().copied().filter(|effect| effect.id != without).collect();
    let request = Request { machine: &machine, recordings: &recordings, holdout: &holdout, vocabulary: &vocabulary };
    Some(diagnose(&request).unwrap().answer)
}
