//! Logs of machines nobody has described, in their own formats and units: `init`, then answers, as a new user has them.

#[path = "own_logs/files.rs"]
mod files;
#[path = "own_logs/plant.rs"]
mod machine;

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use files::{csv, write_mat, write_mcap};
use lab::read::{AxisKind, Machine};
use machine::{ROUNDS, cogging_joint, follow, pushed_pendulum, sprung_axis};
use plant::Model;
use plant::effects::Gravity;
use serde_json::Value;

/// Runs `servo-lab` in a folder; what it prints.
fn lab(folder: &Path, words: &[&str]) -> String {
    let output = Command::cargo_bin("servo-lab").unwrap().current_dir(folder).args(words).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Why `servo-lab` refuses.
fn refused(folder: &Path, words: &[&str]) -> String {
    let output = Command::cargo_bin("servo-lab").unwrap().current_dir(folder).args(words).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{words:?}");
    String::from_utf8(output.stderr).unwrap()
}

fn near(found: f64, truth: f64, within: f64, what: &str) {
    println!("{what}: {found:.5}, in truth {truth:.5}");
    assert!((found / truth - 1.0).abs() < within, "{what}: {found}, in truth {truth}");
}

/// The answer of `diagnose` by the machine file that `init` wrote.
fn diagnosed(folder: &Path, log: &str) -> Value {
    let answer = lab(folder, &["diagnose", "--machine", "machine.toml", log, "--json", "-"]);
    let answer: Value = serde_json::from_str(&answer).unwrap();
    println!("{}: {:#}\nremainder {:#}", answer["verdict"], answer["effects"], answer["remainder"]);
    answer
}

/// A parameter of the first effect of an answer, which must be this one and believed. An ambiguous answer lists what corrects
/// the first model of `init` beside it, and says that the log cannot tell which of its values to correct.
fn value(answer: &Value, effect: &str, parameter: &str) -> f64 {
    let verdict = answer["verdict"].as_str().unwrap();
    assert!(["named", "partial", "ambiguous"].contains(&verdict), "{verdict}");
    let found = &answer["effects"][0];
    assert_eq!(found["id"], effect);
    let parameters = found["parameters"].as_array().unwrap();
    parameters.iter().find(|found| found["id"] == parameter).unwrap()["value"].as_f64().unwrap()
}

/// The gain of the torque that the answer goes with, 1 where it has none.
fn torque_gain(answer: &Value) -> f64 {
    let gain = answer["effects"].as_array().unwrap().iter().find(|effect| effect["id"] == "torque_gain");
    gain.map_or(1.0, |gain| gain["parameters"][0]["value"].as_f64().unwrap())
}

/// `compare` and `doctor` of the log by the machine file that `init` wrote.
fn answers(folder: &Path, log: &str) {
    let compared = lab(folder, &["compare", "--machine", "machine.toml", "--plots", "plots", log]);
    assert!(compared.contains("wrote plots/compare-"), "{compared}");
    let looked = lab(folder, &["doctor", "--machine", "machine.toml", log]);
    assert!(!looked.contains("BAD") && looked.contains("inertia"), "{looked}");
}

/// The log of the pendulum through standard input, and as formats of others, gives the same.
fn the_same_by_any_way_in(folder: &Path, map: &str) {
    lab(folder, &["convert", "log.csv", "--machine", "machine.toml", "-o", "log.mcap"]);
    lab(folder, &["convert", "log.mcap", "-o", "log.parquet"]);
    let compared = |log: &str| {
        let text = lab(folder, &["compare", "--machine", "machine.toml", "--plots", "plots", log]);
        let lines = text.lines().filter(|line| !line.starts_with("wrote"));
        lines.collect::<Vec<_>>().join("\n").replace(log, "LOG")
    };
    assert_eq!(compared("log.mcap"), compared("log.parquet"));
    let log = fs::read(folder.join("log.csv")).unwrap();
    let mut piped = Command::cargo_bin("servo-lab").unwrap();
    let piped = piped.current_dir(folder).args(["init", "-", "--map", map, "-o", "piped.toml"]);
    assert!(piped.write_stdin(log).output().unwrap().status.success());
    let [piped, named] = ["piped.toml", "machine.toml"].map(|file| Machine::read(&folder.join(file)).unwrap());
    assert_eq!((piped.plant, piped.columns), (named.plant, named.columns));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_pendulum_in_degrees_and_amperes() {
    let folder = tempfile::tempdir().unwrap();
    let rows = pushed_pendulum(20.0);
    // The current counts the other way round.
    let reversed: Vec<[f64; 3]> = rows.iter().map(|[t_s, position, effort]| [*t_s, *position, -effort]).collect();
    fs::write(folder.path().join("log.csv"), csv(&reversed)).unwrap();
    let printed = lab(folder.path(), &["init", "log.csv", "-o", "unscaled.toml"]);
    assert!(printed.contains("NOT KNOWN, give --map \"torque=Motor Current [A]:A*SCALE\""), "{printed}");
    let map = "torque=Motor Current [A]:A*-0.12";
    let printed = lab(folder.path(), &["init", "log.csv", "--map", map]);
    println!("{printed}");
    let machine = Machine::read(&folder.path().join("machine.toml")).unwrap();
    near(machine.plant.inertia, 0.05, 0.15, "inertia, kg m2");
    let entry = &machine.effects[0];
    assert_eq!(entry.id, "gravity_load");
    near(entry.parameters[0].1, 1.5, 0.05, "gravity, N m");
    near(entry.parameters[1].1, 0.3, 0.1, "its phase, rad");
    answers(folder.path(), "log.csv");
    // Somebody pushed it.
    let answer = diagnosed(folder.path(), "log.csv");
    near(value(&answer, "disturbance_pulse", "start_s"), 5.0, 0.01, "push, s");
    near(value(&answer, "disturbance_pulse", "amplitude_nm"), -1.0, 0.05, "push, N m");
    // What init guesses by itself has the other sign turned, too.
    let guessed = fs::read_to_string(folder.path().join("unscaled.toml")).unwrap();
    assert!(guessed.contains("scale = -1.0"), "{guessed}");
    the_same_by_any_way_in(folder.path(), map);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_robots_joint_in_mcap() {
    let folder = tempfile::tempdir().unwrap();
    write_mcap(&folder.path().join("arm.mcap"), &cogging_joint(0.002));
    let asked = refused(folder.path(), &["init", "arm.mcap"]);
    assert!(asked.contains("2 joints") && asked.contains("--joint with one of `elbow`, `wrist`"), "{asked}");
    let printed = lab(folder.path(), &["init", "arm.mcap", "--joint", "elbow"]);
    println!("{printed}");
    assert!(printed.contains("`/joint_states.elbow.position` in rad"), "{printed}");
    assert!(printed.contains("/joint_states.elbow.stamp_s"), "the robot's clock, not the host's: {printed}");
    let machine = Machine::read(&folder.path().join("machine.toml")).unwrap();
    near(machine.plant.inertia, 0.02, 0.1, "inertia, kg m2");
    near(machine.plant.coulomb, 0.3, 0.15, "friction, N m");
    near(machine.axis.sample_period_s, 0.002, 0.01, "period, s");
    answers(folder.path(), "arm.mcap");
    let answer = diagnosed(folder.path(), "arm.mcap");
    near(value(&answer, "cogging", "order_per_rev"), 10.0, 0.02, "cogging, periods a turn");
    // A log by itself cannot tell a gain of the torque from all that the torque does; the answer says that it is ambiguous.
    near(value(&answer, "cogging", "amplitude_nm") / torque_gain(&answer), 0.2, 0.05, "cogging, N m");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_linear_axis_in_mat() {
    let folder = tempfile::tempdir().unwrap();
    write_mat(&folder.path().join("axis.mat"), &sprung_axis(0.001));
    let printed = lab(folder.path(), &["init", "axis.mat"]);
    println!("{printed}");
    let machine = Machine::read(&folder.path().join("machine.toml")).unwrap();
    assert_eq!(machine.axis.kind, AxisKind::Linear);
    near(machine.plant.inertia, 12.0, 0.05, "mass, kg");
    assert_eq!(machine.effects.len(), 1, "{:?}", machine.effects);
    let spring = &machine.effects[0];
    assert_eq!(spring.id, "spring_load");
    near(spring.parameters[0].1, 150.0, 0.05, "spring, N/m");
    answers(folder.path(), "axis.mat");
    let answer = diagnosed(folder.path(), "axis.mat");
    near(value(&answer, "cogging", "order_per_m"), 125.0, 0.02, "turns of the screw, 1/m");
    near(value(&answer, "cogging", "amplitude_n") / torque_gain(&answer), 3.0, 0.1, "cogging, N");
}

/// A small pendulum, 0.15 N m level, whose drive has no delay and holds each command of the log for 2 ms, without noise.
fn commanded_pendulum() -> Vec<[f64; 3]> {
    let gravity = Some(Gravity { amplitude: 0.15, phase_rad: 0.0 });
    let model = Model { coulomb: 0.03, viscous: 0.006, gravity, ..Model::new(0.004) };
    follow(&model, [3.0, 0.12, 0.6], 0.002, std::f64::consts::TAU / 8192.0, ROUNDS)
}

/// Half a row between commands that are held and samples of what acts is a viscous friction or a skew of the channels to a model that
/// reads them the other way.
#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation; the tests in release run it")]
fn commands_that_are_held_from_row_to_row() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("log.csv"), csv(&commanded_pendulum())).unwrap();
    lab(folder.path(), &["init", "log.csv", "--map", "torque=Motor Current [A]:A*0.12"]);
    let machine = Machine::read(&folder.path().join("machine.toml")).unwrap();
    near(machine.plant.viscous, 0.006, 0.03, "viscosity of init, N m s/rad");
    let answer = diagnosed(folder.path(), "log.csv");
    for effect in answer["effects"].as_array().unwrap() {
        assert!(effect["id"] != "channel_skew" && effect["id"] != "resolver_eccentricity", "{effect:#}");
    }
}

/// Five rows of 1 ms for each sample that a bus brings, with a stamp of the row before every 400th time and rows behind the end that
/// are the last one again.
fn faster_than_its_bus(samples: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut rows: Vec<[f64; 3]> = samples.iter().flat_map(|sample| [*sample; 5]).collect();
    for (row, [t_s, ..]) in rows.iter_mut().enumerate() {
        *t_s = 1e-3 * (row - usize::from(row > 0 && row % 400 == 0)) as f64;
    }
    rows.extend([*rows.last().unwrap(); 40]);
    rows
}

/// As recordings of a joint with a torque sensor were that a thesis published: rows of 1 ms, a new value every 15th, and times that
/// repeat.
#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation; the tests in release run it")]
fn a_log_that_is_faster_than_its_bus() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("log.csv"), csv(&faster_than_its_bus(&cogging_joint(0.005)))).unwrap();
    let printed = lab(folder.path(), &["init", "log.csv", "--map", "torque=Motor Current [A]:A*0.12"]);
    println!("{printed}");
    for note in
        ["the time repeats in 19 places", "the last 40 rows are the one before again", "a new one in 1600 of 8000 rows"]
    {
        assert!(printed.contains(note), "{note}: {printed}");
    }
    let machine = Machine::read(&folder.path().join("machine.toml")).unwrap();
    near(machine.axis.sample_period_s, 0.005, 0.01, "period, s");
    near(machine.plant.inertia, 0.02, 0.05, "inertia, kg m2");
    near(machine.plant.coulomb, 0.3, 0.15, "friction, N m");
    answers(folder.path(), "log.csv");
}

/// The second thing that is named there is not there: what `init` rounds of the weight, 1 mN m of 1.5 N m, is no value that the
/// judge varies.
#[test]
#[ignore = "unknown: beside the push, right to 0.1 %, an eccentric resolver of 1.5 mrad, and 2 mN m of 12 N m are left"]
fn a_pendulum_with_a_fine_encoder() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("log.csv"), csv(&pushed_pendulum(100.0))).unwrap();
    lab(folder.path(), &["init", "log.csv", "--map", "torque=Motor Current [A]:A*0.12"]);
    let answer = diagnosed(folder.path(), "log.csv");
    near(value(&answer, "disturbance_pulse", "amplitude_nm"), -1.0, 0.01, "push, N m");
    assert_eq!(answer["verdict"], "named");
}

#[test]
fn what_init_cannot_know_it_asks_for() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.csv"), "t,alpha,beta\n0,0,0\n0.001,1,1\n").unwrap();
    let message = refused(folder.path(), &["init", "a.csv"]);
    assert!(
        message.contains("which column is `position`?") && message.contains("--map \"position=NAME:rad\""),
        "{message}"
    );
    let message = refused(folder.path(), &["init", "a.csv", "--map", "positon=alpha"]);
    assert!(message.contains("is `position` meant?"), "{message}");
    let message = refused(folder.path(), &["init", "a.csv", "--map", "position=alpha:lightyears"]);
    assert!(message.contains("is not a unit") || message.contains("not in the log"), "{message}");
    fs::write(folder.path().join("b.h5"), b"\x89HDF\r\n\x1a\n\0\0\0\0\0\0\0\0").unwrap();
    let message = refused(folder.path(), &["init", "b.h5"]);
    assert!(message.contains("is not an HDF5 file that can be read, or was cut short"), "{message}");
    assert!(!folder.path().join("machine.toml").exists());
}

#[test]
fn help_names_effects_and_what_is_near() {
    let folder = tempfile::tempdir().unwrap();
    let effects = lab(folder.path(), &["help", "effects"]);
    assert!(
        effects.contains("coulomb_friction\n    Dry friction") && effects.contains("coulomb_nm (coulomb_n)"),
        "{effects}"
    );
    let formats = lab(folder.path(), &["help", "formats"]);
    assert!(
        formats.contains("\nMCAP (JSON, Protobuf, joint states of ROS 2 and Foxglove)\n    of messages"),
        "{formats}"
    );
    assert!(refused(folder.path(), &["help", "efects"]).contains("is `effects` meant?"));
    let near = refused(folder.path(), &["diagnose", "--machine", "machine.toml", "--only", "colomb_friction", "a.csv"]);
    assert!(near.contains("the nearest is `coulomb_friction`"), "{near}");
    assert!(lab(folder.path(), &["completions", "bash"]).contains("servo-lab"));
    lab(folder.path(), &["man", "--out", "man"]);
    assert!(fs::read_to_string(folder.path().join("man/servo-lab-init.1")).unwrap().contains("machine file"));
}

#[test]
fn every_command_has_an_example_with_flags_that_exist() {
    let folder = tempfile::tempdir().unwrap();
    for command in [
        "init",
        "convert",
        "doctor",
        "simulate",
        "diagnose",
        "compare",
        "link",
        "record",
        "tune",
        "stability",
        "paper",
        "prove",
        "fleet",
        "delays",
        "guide",
        "replay",
        "decode",
        "commission",
    ] {
        let help = lab(folder.path(), &[command, "--help"]);
        assert!(help.contains("Example:\n  servo-lab "), "{command}: {help}");
        // With `--help` behind it an example does nothing, and one with a flag that does not exist is refused.
        for example in help.lines().filter_map(|line| line.strip_prefix("  servo-lab ")) {
            let words: Vec<&str> = example.split_whitespace().chain(["--help"]).collect();
            assert!(lab(folder.path(), &words).contains("Usage:"), "{example}");
        }
    }
}
