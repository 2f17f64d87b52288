//! What a verdict may say: nothing of a value that may be the nominal one, and no experiment that tells nothing.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;

const NOMINAL_COULOMB_NM: f64 = 0.763;

fn machine(coulomb_nm: f64) -> String {
    format!(
        "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\nresolution = 1.2783173e-5\n\
         [plant]\ninertia = 0.075\ncoulomb = {coulomb_nm}\ntorque_limit = 30\ntorque_delay_s = 0.005\n\
         [plant.er]\na = 0.0704\nb = 0.470\ndead_time_s = 0.002\nlag_s = 0.003\n"
    )
}

fn lab(folder: &Path, words: &[&str]) -> String {
    let output = Command::cargo_bin("servo-lab").unwrap().current_dir(folder).args(words).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Friction off by so little that an interval holds the nominal value, up to so much that it cannot.
#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_value_that_may_be_the_nominal_one_is_not_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(NOMINAL_COULOMB_NM)).unwrap();
    let (mut named, mut unnamed) = (0, 0);
    for (seed, off_nm) in [0.0, 0.001, 0.003, 0.006, 0.01, 0.02, 0.05, 0.15].into_iter().enumerate() {
        fs::write(folder.path().join("truth.toml"), machine(NOMINAL_COULOMB_NM + off_nm)).unwrap();
        let seed = (seed + 1).to_string();
        let simulate =
            ["simulate", "steps", "--machine", "truth.toml", "--duration-s", "3", "--torque-noise-nm", "0.1"];
        lab(folder.path(), &[&simulate[..], &["--seed", &seed, "-o", "run.csv", "--force"]].concat());
        let only = ["--only", "coulomb_friction,viscous_friction,torque_offset", "--json", "-"];
        let answer = lab(folder.path(), &[&["diagnose", "--machine", "m.toml", "run.csv"], &only[..]].concat());
        let answer: Value = serde_json::from_str(&answer).unwrap();
        let effects = answer["effects"].as_array().unwrap();
        println!("{off_nm} N m: {} {effects:?}", answer["verdict"]);
        if effects.is_empty() || answer["verdict"] == "unknown" {
            unnamed += 1;
            continue;
        }
        named += 1;
        for value in effects.iter().flat_map(|effect| effect["parameters"].as_array().unwrap()) {
            let nominal = if value["id"] == "coulomb_nm" { NOMINAL_COULOMB_NM } else { 0.0 };
            let (low, high) = (value["low"].as_f64().unwrap(), value["high"].as_f64().unwrap());
            assert!(low > nominal || high < nominal, "{off_nm} N m: {value} holds {nominal}");
        }
    }
    assert!(named >= 2 && unnamed >= 2, "the sizes are around what can be told: {named} named, {unnamed} not");
}

/// The folder of real recordings; none, with the reason printed, where it is not there. In CI it must be.
fn shared() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let found =
        ["../shared/data", "../../shared/data"].map(|folder| root.join(folder)).into_iter().find(|f| f.is_dir());
    assert!(found.is_some() || std::env::var_os("CI").is_none(), "../shared/data must be there in CI");
    if found.is_none() {
        println!("skipped: the folder of real recordings, ../shared/data, is not there");
    }
    found
}

/// A pendulum without a fluid whose recording does not tell its effects apart.
#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn without_an_experiment_that_tells_the_answer_says_what_would() {
    let Some(data) = shared() else { return };
    let at = |name: &str| data.join("dfki").join(name).to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let words = ["diagnose", "--machine", &at("heavy_none.toml"), &at("dircol.csv"), "--json", "-"];
    let answer: Value = serde_json::from_str(&lab(folder.path(), &words)).unwrap();
    println!("{} {}", answer["verdict"], answer["experiment"]);
    if answer["verdict"] != "ambiguous" {
        return;
    }
    let experiment = answer["experiment"]["text"].as_str().unwrap_or_default();
    for absent in ["brake", "field", "power 0.00"] {
        assert!(!experiment.contains(absent), "the machine has no fluid: {experiment}");
    }
    if answer["experiment"].is_null() {
        let warnings = answer["warnings"].to_string();
        assert!(warnings.contains("weighing") && warnings.contains("torque sensor"), "{warnings}");
    }
}
