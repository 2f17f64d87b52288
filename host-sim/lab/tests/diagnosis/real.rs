//! Recordings of a real machine, read from the shared data; skipped where they are not there.

use std::path::Path;

use diagnosis::effects::VOCABULARY;
use lab::conclude::{Request, diagnose};
use lab::read::{Machine, Recording};
use lab::report::Answer;

#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation; the tests in release run it")]
fn dry_friction_of_the_emps_axis_comes_first_and_within_five_percent() {
    let Some(answer) = diagnosed("emps", &["train.csv"], &[], "") else { return };
    let first = &answer.effects[0];
    assert_eq!(first.id, "coulomb_friction", "{answer:?}");
    assert!((first.parameters[0].value / 20.39 - 1.0).abs() < 0.05, "{first:?}");
}

/// The published model has an offset of 3.165 N and no asymmetry, which explains the same.
#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation; the tests in release run it")]
fn without_an_asymmetry_the_emps_axis_has_the_published_offset() {
    let Some(answer) = diagnosed("emps", &["train.csv"], &["pulses.csv"], "friction_asymmetry") else { return };
    assert_eq!(answer.effects[0].id, "coulomb_friction", "{answer:?}");
    let offset = answer.effects.iter().find(|effect| effect.id == "torque_offset").unwrap();
    let value = &offset.parameters[0];
    assert!(value.low < 3.165 && 3.165 < value.high, "{offset:?}");
    let fit = &answer.fit;
    let excess = |rms: f64| rms.powi(2) - fit.heldout_floor_rms.powi(2);
    assert!(excess(fit.heldout_after_rms) < 0.3 * excess(fit.heldout_before_rms), "{fit:?}");
}

/// Amplitudes of the separate map `map_a_4.csv`, N m.
const MAP: [(f64, f64); 2] = [(7.0, 0.0475), (28.0, 0.0309)];

#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation; the tests in release run it")]
fn cogging_of_the_odrive_motor_has_the_orders_and_sizes_of_its_map() {
    let Some(answer) = diagnosed("odrive_cogging", &["slow2_nocomp_0.csv"], &["slow2_nocomp_1.csv"], "") else {
        return;
    };
    let named: Vec<_> = answer.effects.iter().map(|effect| (effect.id.as_str(), &effect.parameters)).collect();
    println!("{:?} {named:?}", answer.verdict);
    let waves = || answer.effects.iter().filter(|effect| effect.id == "cogging");
    for (order, amplitude) in MAP {
        let found = waves().find(|effect| (effect.parameters[1].value - order).abs() < 0.1).unwrap();
        let ratio = found.parameters[0].value / amplitude;
        assert!((ratio - 1.0).abs() < 0.2, "order {order}: {ratio:.3} of the map");
    }
    // The current is logged behind a filter of 0.1 s.
    assert!(named.iter().any(|(id, _)| *id == "torque_filter"), "{named:?}");
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
