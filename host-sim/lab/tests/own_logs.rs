//! Logs of machines nobody has described, in their own formats and units: `init`, then answers, as a new user has them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use lab::read::Machine;
use plant::effects::Gravity;
use plant::{Command as Effort, Model, Plant, State};

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

/// Time, position and effort of a machine under a spring and a damper that follow two sines.
fn run(model: &Model, [stiffness, damping, amplitude]: [f64; 3], period_s: f64, step: f64) -> Vec<[f64; 3]> {
    let mut plant = Plant::new(model, State::default(), 0.0).unwrap();
    let mut rows = Vec::new();
    for tick in 0..(8.0 / period_s) as u32 {
        let t_s = f64::from(tick) * period_s;
        let reference = amplitude * ((3.1 * t_s).sin() + 0.4 * (14.0 * t_s).sin());
        let state = plant.state();
        let position = (state.position / step).round() * step;
        let effort = stiffness * (reference - state.position) - damping * state.velocity;
        rows.push([t_s, position, effort]);
        plant.advance(&Effort::new(effort, 0.0), t_s + period_s).unwrap();
    }
    rows
}

fn near(found: f64, truth: f64, within: f64, what: &str) {
    println!("{what}: {found:.5}, in truth {truth:.5}");
    assert!((found / truth - 1.0).abs() < within, "{what}: {found}, in truth {truth}");
}

/// A drive's export in a country with a decimal comma: ms, degrees, amperes of a motor with 0.12 N m/A.
fn csv(rows: &[[f64; 3]]) -> String {
    let mut text = String::from("Zeit [ms];Winkel [deg];Motor Current [A]\n");
    for [t_s, position, effort] in rows {
        let line = format!("{:.3};{:.4};{:.5}", 1e3 * t_s, position.to_degrees(), effort / 0.12);
        writeln!(text, "{}", line.replace('.', ",")).unwrap();
    }
    text
}

/// `compare` and `doctor` of the log by the machine file that `init` wrote.
fn answers(folder: &Path, log: &str) {
    let compared = lab(folder, &["compare", "--machine", "machine.toml", "--plots", "plots", log]);
    assert!(compared.contains("wrote plots/compare-"), "{compared}");
    let looked = lab(folder, &["doctor", "--machine", "machine.toml", log]);
    assert!(!looked.contains("BAD") && looked.contains("inertia"), "{looked}");
}

#[test]
fn a_pendulum_in_degrees_and_amperes() {
    let folder = tempfile::tempdir().unwrap();
    let gravity = Some(Gravity { amplitude: 1.5, phase_rad: 0.3 });
    let model = Model { coulomb: 0.1, viscous: 0.02, gravity, ..Model::new(0.05) };
    let rows = run(&model, [9.0, 0.8, 1.2], 0.002, 1.0_f64.to_radians() / 20.0);
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
    // What init guesses by itself has the other sign turned, too.
    let guessed = fs::read_to_string(folder.path().join("unscaled.toml")).unwrap();
    assert!(guessed.contains("scale = -1.0"), "{guessed}");
    // The same log packed, through standard input, and as formats of others.
    lab(folder.path(), &["convert", "log.csv", "--machine", "machine.toml", "-o", "converted.csv"]);
    lab(folder.path(), &["convert", "converted.csv", "-o", "log.parquet"]);
    let compared = |log: &str| {
        let text = lab(folder.path(), &["compare", "--machine", "machine.toml", "--plots", "plots", log]);
        let lines = text.lines().filter(|line| !line.starts_with("wrote"));
        lines.collect::<Vec<_>>().join("\n").replace(log, "LOG")
    };
    assert_eq!(compared("converted.csv"), compared("log.parquet"));
    let log = fs::read(folder.path().join("log.csv")).unwrap();
    let mut piped = Command::cargo_bin("servo-lab").unwrap();
    let piped = piped.current_dir(folder.path()).args(["init", "-", "--map", map, "-o", "piped.toml"]);
    assert!(piped.write_stdin(log).output().unwrap().status.success());
    let [piped, named] = ["piped.toml", "machine.toml"].map(|file| Machine::read(&folder.path().join(file)).unwrap());
    assert_eq!((piped.plant, piped.columns), (named.plant, named.columns));
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
    assert!(message.contains("is an HDF5 file") && message.contains("can be read: CSV"), "{message}");
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
    assert!(refused(folder.path(), &["help", "efects"]).contains("is `effects` meant?"));
    let near = refused(folder.path(), &["diagnose", "--machine", "machine.toml", "--only", "colomb_friction", "a.csv"]);
    assert!(near.contains("the nearest is `coulomb_friction`"), "{near}");
    assert!(lab(folder.path(), &["completions", "bash"]).contains("servo-lab"));
    lab(folder.path(), &["man", "--out", "man"]);
    assert!(fs::read_to_string(folder.path().join("man/servo-lab-init.1")).unwrap().contains("machine file"));
    for command in ["init", "convert", "doctor", "simulate", "diagnose", "compare", "link", "record", "tune"] {
        let help = lab(folder.path(), &[command, "--help"]);
        assert!(help.contains("Example:\n  servo-lab "), "{command}: {help}");
    }
}
