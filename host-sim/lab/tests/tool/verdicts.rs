//! What a verdict may say: nothing of a value that may be the nominal one, and no experiment that tells nothing.

use std::fs;
use std::path::Path;

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
        if effects.is_empty() {
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

/// A machine file of a fifteenth of the inertia, which is more than is looked at: the answer says that its value is an end and no estimate.
#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_value_at_the_end_of_what_is_looked_at_is_told_as_such() {
    let folder = tempfile::tempdir().unwrap();
    let simulated = machine(NOMINAL_COULOMB_NM);
    fs::write(folder.path().join("truth.toml"), &simulated).unwrap();
    let simulate = ["simulate", "steps", "--machine", "truth.toml", "--duration-s", "3", "--torque-noise-nm", "0.1"];
    lab(folder.path(), &[&simulate[..], &["-o", "run.csv"]].concat());
    for (inertia, at_an_end) in [("0.005", true), ("0.05", false)] {
        let machine = simulated.replace("inertia = 0.075", &format!("inertia = {inertia}"));
        fs::write(folder.path().join("m.toml"), machine).unwrap();
        let answer =
            lab(folder.path(), &["diagnose", "--machine", "m.toml", "run.csv", "--only", "inertia", "--json", "-"]);
        let answer: Value = serde_json::from_str(&answer).unwrap();
        assert_eq!(answer["effects"][0]["id"], "inertia", "{inertia}: {answer}");
        let warned = answer["warnings"].to_string().contains("inertia: its value is the last that is looked at");
        assert_eq!(warned, at_an_end, "{inertia}: {answer}");
    }
}

/// A share as every output has it: per cent with one decimal, rounded down.
fn rounded_down(share: f64) -> String {
    format!("{:.1}", (1000.0 * share + 1e-9).floor() / 10.0)
}

/// The same residual in the JSON, on the terminal and on the page: one number, never rounded up.
#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn one_residual_is_one_number_on_terminal_page_and_in_json() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), machine(NOMINAL_COULOMB_NM)).unwrap();
    fs::write(folder.path().join("truth.toml"), machine(NOMINAL_COULOMB_NM + 0.3)).unwrap();
    let simulate = ["simulate", "steps", "--machine", "truth.toml", "--duration-s", "3", "--torque-noise-nm", "0.1"];
    lab(folder.path(), &[&simulate[..], &["-o", "run.csv"]].concat());
    let only = ["--only", "coulomb_friction,viscous_friction", "--json", "a.json", "--html", "a.html"];
    let terminal = lab(folder.path(), &[&["diagnose", "--machine", "m.toml", "run.csv"], &only[..]].concat());
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let (answer, page): (Value, String) = (serde_json::from_str(&read("a.json")).unwrap(), read("a.html"));
    let fit = |key: &str| answer["fit"][key].as_f64().unwrap();
    let less = rounded_down(1.0 - fit("heldout_after_rms") / fit("heldout_before_rms"));
    let explained = rounded_down(fit("excess_explained"));
    let gain = rounded_down(answer["effects"][0]["evidence"]["heldout_gain"].as_f64().unwrap());
    println!("{terminal}");
    assert!(less.parse::<f64>().unwrap() > 10.0, "the friction is most of what is missing: {less} %");
    for (text, parts) in [
        (
            &terminal,
            [
                format!("after ({less} % less)"),
                format!("{explained} % of the excess explained"),
                format!("accounts for up to {gain} % of the held-out error"),
            ],
        ),
        (
            &page,
            [
                format!("<td>{less} %</td>"),
                format!("explains {explained} % of the excess"),
                format!("Accounts for up to {gain} % of the held-out error"),
            ],
        ),
    ] {
        parts.iter().for_each(|part| assert!(text.contains(part), "{part} is not there"));
    }
    // No fit leaves less than nothing, and no floor is above what is left.
    for (floor, after) in [("noise_floor_rms", "after_rms"), ("heldout_floor_rms", "heldout_after_rms")] {
        assert!(fit(floor) <= fit(after), "{floor} above {after}");
    }
}

/// What a diagnosis answers of a machine when its model is another; six seconds of the reference.
fn diagnosed(model: &str, truth: &str, reference: &str, only: &str) -> (tempfile::TempDir, Value) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), model).unwrap();
    fs::write(folder.path().join("truth.toml"), truth).unwrap();
    let reference: Vec<&str> = reference.split_whitespace().collect();
    let noise = ["--machine", "truth.toml", "--duration-s", "6", "--torque-noise-nm", "0.05", "-o", "run.csv"];
    lab(folder.path(), &[&["simulate"], &reference[..], &noise[..]].concat());
    let words = ["diagnose", "--machine", "m.toml", "run.csv", "--only", only, "--experiment", "next.csv"];
    let answer = serde_json::from_str(&lab(folder.path(), &[&words[..], &["--json", "-"]].concat())).unwrap();
    println!("{only}: {answer:#}");
    (folder, answer)
}

/// The part of the model before the fluid.
fn without_fluid(model: &str) -> &str {
    model.split("[plant.er]").next().unwrap()
}

/// A slow sine shows the friction, and not whether it is a dead band of the drive; the motion that is proposed tells.
#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn an_experiment_that_is_proposed_has_power_and_fits_the_machine() {
    let (model, truth) = (machine(NOMINAL_COULOMB_NM), machine(NOMINAL_COULOMB_NM + 0.067));
    for (model, truth) in [(&model[..], &truth[..]), (without_fluid(&model), without_fluid(&truth))] {
        let sine = "chirp --low-hz 0.4 --high-hz 0.4 --amplitude-deg 28";
        let (folder, answer) = diagnosed(model, truth, sine, "coulomb_friction,torque_deadband");
        assert_eq!(answer["verdict"], "ambiguous");
        let text = answer["experiment"]["text"].as_str().unwrap();
        let power = text.rsplit_once("predicted power ").unwrap().1.trim_end_matches('.');
        assert!(power.parse::<f64>().unwrap() >= 0.5, "{text}");
        if !model.contains("[plant.er]") {
            assert!(!text.contains("brake") && !text.contains("field"), "there is no fluid: {text}");
        }
        let rows = fs::read_to_string(folder.path().join("next.csv")).unwrap().lines().count();
        assert!(rows > 1000, "the reference is written: {rows} rows");
        assert!(!answer["warnings"].to_string().contains("weighing"), "{}", answer["warnings"]);
    }
}

/// Of a fluid whose torque goes with the square of the field alone, no motion tells a weaker field from a weaker fluid.
#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn without_an_experiment_that_tells_the_answer_says_what_would() {
    let square = |a: f64| machine(NOMINAL_COULOMB_NM).replace("a = 0.0704\nb = 0.470", &format!("a = {a}\nb = 0.0"));
    let (folder, answer) = diagnosed(&square(0.2), &square(0.22), "steps", "field_gain,er_strength");
    assert_eq!(answer["verdict"], "ambiguous");
    let text = answer["experiment"]["text"].as_str().unwrap();
    assert!(text.starts_with("No motion within the limits of speed, torque and travel tells "), "{text}");
    assert!(text.contains("Instead measure the voltage over the gap of the fluid"), "{text}");
    assert!(!text.contains("power") && answer["experiment"]["reference_csv"].is_null(), "{answer:#}");
    assert!(!folder.path().join("next.csv").exists(), "there is nothing to record");
    assert!(!answer["warnings"].to_string().contains("another motion"), "{}", answer["warnings"]);
}

/// A pendulum without friction but its bearing's, 8 s under three tones that are held from row to row, in rows of `period_ms`, by
/// fourth-order Runge-Kutta steps of 0.2 ms.
fn pendulum(period_ms: u32, gravity_nm: f64, phase_rad: f64) -> String {
    let (inertia, viscous, step, h) = (0.075, 0.05, 1.278_317_3e-5, 2e-4);
    let (mut q, mut v) = (0.0_f64, 0.0_f64);
    let mut text = "t_s,position_rad,torque_cmd_nm\n".to_owned();
    for row in 0..8000 / period_ms {
        let t_s = f64::from(row * period_ms) * 1e-3;
        let torque = 2.0 * (2.1 * t_s).sin() + 1.2 * (7.3 * t_s + 1.0).sin() + 0.8 * (19.0 * t_s).sin();
        text.push_str(&format!("{t_s:.4},{},{torque}\n", (q / step).round() * step));
        let rate = |q: f64, v: f64| (torque - viscous * v - gravity_nm * (q + phase_rad).sin()) / inertia;
        for _ in 0..5 * period_ms {
            let (v1, a1) = (v, rate(q, v));
            let (v2, a2) = (v + 0.5 * h * a1, rate(q + 0.5 * h * v1, v + 0.5 * h * a1));
            let (v3, a3) = (v + 0.5 * h * a2, rate(q + 0.5 * h * v2, v + 0.5 * h * a2));
            let (v4, a4) = (v + h * a3, rate(q + h * v3, v + h * a3));
            q += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
            v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        }
    }
    text
}

/// What the model lacks is named with its value however coarse the rows are, and no floor is above what is left.
#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation; the tests in release run it")]
fn gravity_is_named_at_coarse_sampling_and_the_floor_is_below_what_is_left() {
    let (gravity_nm, phase_rad) = (3.2, 0.4);
    let folder = tempfile::tempdir().unwrap();
    let machine = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 1e-3\n\
                   resolution = 1.2783173e-5\n[plant]\ninertia = 0.075\nviscous = 0.05\ntorque_limit = 30\n";
    fs::write(folder.path().join("m.toml"), machine).unwrap();
    for period_ms in [1, 5, 6] {
        fs::write(folder.path().join("run.csv"), pendulum(period_ms, gravity_nm, phase_rad)).unwrap();
        let only = "gravity_load,coulomb_friction,viscous_friction,torque_offset,spring_load";
        let words = ["diagnose", "--machine", "m.toml", "run.csv", "--only", only, "--json", "-"];
        let answer: Value = serde_json::from_str(&lab(folder.path(), &words)).unwrap();
        println!("{period_ms} ms: {} {} {}", answer["verdict"], answer["effects"], answer["fit"]);
        assert!(answer["verdict"] == "named" || answer["verdict"] == "partial", "{period_ms} ms: {answer:#}");
        let effects = answer["effects"].as_array().unwrap();
        assert!(effects.len() == 1 && effects[0]["id"] == "gravity_load", "{period_ms} ms: {effects:?}");
        for (value, truth) in effects[0]["parameters"].as_array().unwrap().iter().zip([gravity_nm, phase_rad]) {
            let (low, high) = (value["low"].as_f64().unwrap(), value["high"].as_f64().unwrap());
            assert!(low <= truth && truth <= high, "{period_ms} ms: {value} without {truth}");
        }
        let fit = |key: &str| answer["fit"][key].as_f64().unwrap();
        assert!(fit("noise_floor_rms") <= fit("after_rms") && fit("after_rms") < 0.1 * fit("before_rms"), "{answer:#}");
    }
}
