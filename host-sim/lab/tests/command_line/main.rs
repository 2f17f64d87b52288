//! The commands as a user runs them: what they print, what they write, and how they refuse.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod help;

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

const MACHINE: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\n\
                       resolution = 1.2783173e-5\n[plant]\ninertia = 0.075\ncoulomb = 0.763\ntorque_limit = 30\n\
                       torque_delay_s = 0.005\n[plant.er]\na = 0.0704\nb = 0.470\ndead_time_s = 0.002\nlag_s = 0.003\n";

/// Runs `servo-lab` in a folder.
fn lab(folder: &Path, line: &str) -> Output {
    let words = line.split_whitespace();
    Command::cargo_bin("servo-lab").unwrap().current_dir(folder).args(words).output().unwrap()
}

fn printed(folder: &Path, line: &str) -> String {
    let output = lab(folder, line);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}: {errors}");
    assert_eq!(errors, "", "{line}: progress and notes stay off a pipe");
    String::from_utf8(output.stdout).unwrap()
}

/// Exit code 2, one line of message that holds `message`, nothing on standard output, no file written.
fn refused(folder: &Path, line: &str, message: &str) {
    let names = |folder: &Path| {
        let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let before = names(folder);
    let output = lab(folder, line);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}: {errors}");
    assert!(errors.lines().count() == 1 && errors.contains(message), "{line}: {errors}");
    assert!(output.stdout.is_empty(), "{line}");
    assert_eq!(names(folder), before, "{line}");
}

/// A folder with a machine, one that has a controller, and a recording of it.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("machine.toml"), MACHINE).unwrap();
    fs::write(at("controlled.toml"), format!("{MACHINE}[controller]\nkp_nm_rad = 240\n")).unwrap();
    fs::write(at("linear.toml"), MACHINE.replace("rotary", "linear")).unwrap();
    fs::write(at("bad.toml"), MACHINE.replace("inertia = 0.075", "inertia = -1")).unwrap();
    fs::write(at("bad.csv"), "t_s,position_rad,torque_cmd_nm\n0,0,1\n0.0005,x,1\n").unwrap();
    fs::write(at("short.csv"), "t_s,position_rad,torque_cmd_nm,reference_rad\n0,0,0,0\n0.0005,0,0,0\n").unwrap();
    fs::write(at("no_reference.csv"), "t_s,position_rad,torque_cmd_nm\n0,0,1\n0.0005,0,1\n").unwrap();
    fs::write(at("bad_reference.csv"), "t_s,reference_rad\n0,0\n0,1\n").unwrap();
    fs::write(at("text.txt"), "not a recording").unwrap();
    printed(folder.path(), "simulate --duration-s 0.3 --out run.csv");
    folder
}

/// The fastest of several, for a computer with other work starts nothing at once.
#[test]
fn the_version_is_told_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let took = (0..20).map(|_| {
        let start = std::time::Instant::now();
        assert!(printed(folder.path(), "--version").starts_with("servo-lab "));
        start.elapsed()
    });
    let fastest = took.min().unwrap();
    println!("servo-lab --version: {fastest:?}");
    // A debug build is ten times the file to map.
    assert!(fastest.as_millis() < if cfg!(debug_assertions) { 100 } else { 20 }, "{fastest:?}");
}

#[test]
fn bad_input_of_every_command_is_one_line_and_writes_nothing() {
    let folder = folder();
    let cases = [
        ("simulate --machine missing.toml --out out.csv", "missing.toml: cannot open"),
        ("simulate --machine bad.toml --out out.csv", "bad.toml:8: plant.inertia"),
        ("simulate --machine linear.toml --out out.csv", "linear.toml: axis.kind"),
        ("simulate --reference missing.csv --out out.csv", "missing.csv: cannot open"),
        ("simulate --reference bad_reference.csv --out out.csv", "bad_reference.csv:3: t_s: 0 does not rise"),
        ("simulate --duration-s=-1 --out out.csv", "--duration-s: -1 is not allowed"),
        ("simulate --duration-s nan --out out.csv", "--duration-s: NaN is not allowed"),
        ("simulate --amplitude-deg 500 --out out.csv", "--amplitude-deg: 500 is not allowed, -360 to 360 is"),
        ("simulate --amplitude-deg 4000 --out out.csv", "--amplitude-deg: 4000 is not allowed, -360 to 360 is"),
        (
            "simulate ramp --travel-deg=-5 --out out.csv",
            "--amplitude-deg (or --travel-deg): -5 is not allowed, 0.00573 to",
        ),
        (
            "simulate ramp --amplitude-deg 1e6 --out out.csv",
            "--amplitude-deg (or --travel-deg): 1000000 is not allowed",
        ),
        ("simulate multisine --tones 0 --out out.csv", "--tones: 0 is not allowed, 1 to 16 is"),
        ("simulate chirp --high-hz 1000 --out out.csv", "--high-hz (or --to-hz): 1000 is not allowed"),
        ("simulate chirp --to-hz 1000 --out out.csv", "--high-hz (or --to-hz): 1000 is not allowed"),
        ("simulate ramp --speed-rad-s 0 --out out.csv", "--speed-rad-s: 0 is not allowed"),
        ("simulate steps --dwell-s 0 --out out.csv", "--dwell-s: 0 is not allowed"),
        ("simulate --fluid q --dead-time-ms 5 --lag-ms 5 --out out.csv", "not both"),
        ("simulate --fluid none --lag-ms 5 --out out.csv", "--fluid none has no delay"),
        ("simulate --fluid e --as-printed --out out.csv", "--as-printed is a reading of --fluid q"),
        ("simulate --fluid e --lag-ms=-5 --out out.csv", "--lag-ms: -5 ms is not allowed"),
        ("simulate --fluid e --dead-time-ms nan --out out.csv", "--dead-time-ms: NaN ms is not allowed"),
        ("simulate --drive-delay-ms=-5 --out out.csv", "--drive-delay-ms: -5 ms is not allowed, 0 to 1000 is"),
        ("simulate --sensor-noise-rad nan --out out.csv", "noise_sd"),
        ("simulate --torque-noise-nm=-1 --out out.csv", "torque_noise_sd"),
        ("simulate --disturbance 0.1,-1,8 --out out.csv", "duration_s"),
        ("stability --fluid dead-time --lag-ms 3", "--dead-time-ms is the delay of --fluid dead-time"),
        ("help bogus", "there is no command and no topic `bogus`; there are init, convert, doctor"),
        ("help link runn", "`link` has no action `runn`; is `run` meant?"),
        ("help doctor run", "`doctor` has no action `run`; it has none"),
        ("help effects run", "`effects` is no command with an action `run`"),
        ("help cogin", "there is no command and no topic `cogin`; is `cogging` meant?"),
        ("prove --plan fixed --effect cogin", "there is no effect `cogin`; the nearest is `cogging`"),
        ("replay missing.csv", "missing.csv: cannot open"),
        ("replay bad.csv", "bad.csv:3: position_rad"),
        ("replay text.txt", "text.txt:1: t_s, position_rad, torque_cmd_nm: required columns are missing"),
        ("replay no_reference.csv", "no_reference.csv: replay needs the column reference_rad"),
        ("replay --machine machine.toml run.csv", "machine.toml: controller: no [controller] section"),
        ("replay --machine bad.toml run.csv", "bad.toml:8: plant.inertia"),
        ("compare --machine missing.toml run.csv", "missing.toml: cannot open"),
        ("compare --machine bad.toml run.csv", "bad.toml:8: plant.inertia"),
        ("compare --machine linear.toml run.csv", "run.csv"),
        ("compare --machine machine.toml bad.csv", "bad.csv:3: position_rad"),
        ("compare --machine machine.toml run.csv bad.csv", "bad.csv:3: position_rad"),
        ("compare --machine machine.toml short.csv", "short.csv: 0.001 s is too short, at least 0.2 s is needed"),
        (
            "compare --machine machine.toml run.csv short.csv",
            "short.csv: 0.001 s is too short, at least 0.2 s is needed",
        ),
    ];
    for (line, message) in cases {
        refused(folder.path(), line, message);
    }
}

#[test]
fn a_late_viscosity_is_bounded_unless_it_is_read_as_printed() {
    let folder = tempfile::tempdir().unwrap();
    let step = "simulate --fluid q --dead-time-ms 50 --true-speed --duration-s 1";
    // Control.md sections 5 and 7.
    for (flags, settling) in [(" --plot run.svg", "91.0 ms"), (" --as-printed", "126.5 ms")] {
        let summary = printed(folder.path(), &format!("{step}{flags}"));
        assert!(summary.contains(&format!("settling         {settling}")), "{flags}: {summary}");
    }
    let drawn = fs::read_to_string(folder.path().join("run.svg")).unwrap();
    assert!(
        ["fluid, at most", "field (kV/mm)", "command", "acts, of the torque"].iter().all(|text| drawn.contains(text))
    );
}

/// Reference minus position at the end of a step, rad.
fn residual_mrad(folder: &Path, flags: &str) -> f64 {
    let summary = printed(folder, &format!("simulate --true-speed --duration-s 1 --fluid {flags}"));
    let line = summary.lines().find(|line| line.starts_with("residual")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

#[test]
fn a_brake_that_holds_keeps_a_late_field_from_returning() {
    let folder = tempfile::tempdir().unwrap();
    // Control.md section 7, in u = c / K_P.
    let held_mrad = 0.763 / 0.24;
    for (fluid, low, high) in [("e --dead-time-ms 2 --lag-ms 3", 1.97, 2.03), ("none", 1.02, 1.04)] {
        let residual_u = residual_mrad(folder.path(), &format!("{fluid} --hold")) / held_mrad;
        assert!((low..=high).contains(&residual_u), "{fluid}: {residual_u} u");
        let without_u = residual_mrad(folder.path(), fluid) / held_mrad;
        assert!((0.98..=1.07).contains(&without_u), "{fluid}: {without_u} u without");
    }
}

#[test]
fn a_mode_beside_the_law_is_named_in_the_recording_and_not_replayed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let law = "simulate --amplitude-deg 3 --duration-s 0.3";
    let plain = printed(at, law);
    for extension in ["csv", "parquet", "mcap"] {
        let mode = printed(at, &format!("{law} --mode lead --out lead.{extension}"));
        assert!(!mode.contains(&plain), "{mode}");
        let message = format!("lead.{extension}: the mode `lead` commanded, which the flashed law does not have");
        refused(at, &format!("replay lead.{extension}"), &message);
    }
    assert!(printed(at, "simulate --help").contains("predictor-lead-gains-1.25"));
    let unknown = lab(at, "simulate --mode leads");
    assert_eq!(unknown.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("a similar value exists: 'lead'"));
    refused(at, "simulate --mode lead --fluid q --lag-ms 5", "--mode lead: a mode commands a field");
}

#[test]
fn the_physics_of_a_fluid_acts_in_simulations_and_nowhere_is_it_ignored() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("plain.toml"), MACHINE).unwrap();
    let with = |keys: &str| fs::write(at.join("fluid.toml"), format!("{MACHINE}[plant.er.fluid]\n{keys}\n")).unwrap();
    let simulated = |machine: &str| {
        printed(at, &format!("simulate step --duration-s 0.2 --machine {machine} --out {machine}.csv --force"));
        fs::read_to_string(at.join(format!("{machine}.csv"))).unwrap()
    };
    let plain = simulated("plain.toml");
    with("");
    assert_eq!(simulated("fluid.toml"), plain, "defaults change nothing");
    for keys in [
        "consistency = 0.3\nflow_exponent = 0.5",
        "rise_exponent = 2.0",
        "above_reference_k = 10.0\nyield_per_k = 0.02",
        "electrode_capacitance_f = 1e-8\namplifier_current_a = 1e-4\ngap_m = 5e-4",
    ] {
        with(keys);
        assert_ne!(simulated("fluid.toml"), plain, "{keys}");
    }
    refused(at, "simulate step --machine fluid.toml --fluid q --dead-time-ms 5", "plant.er.fluid: follows a field");
    refused(at, "delays --machine fluid.toml plain.toml.csv", "plant.er.fluid: is for `simulate` and `tune`");
    refused(at, "diagnose --machine fluid.toml plain.toml.csv", "plant.er.fluid: is for `simulate` and `tune`");
    refused(at, "compare --machine fluid.toml plain.toml.csv", "plant.er.fluid: is for `simulate` and `tune`");
    refused(at, "stability --machine fluid.toml", "plant.er.fluid: is for `simulate` and `tune`");
    with("gap_m = 5e-4");
    refused(at, "simulate step --machine fluid.toml", "plant.er.fluid.electrode_capacitance_f: is missing");
    with("flow_exponents = 0.5");
    refused(at, "simulate step --machine fluid.toml", "the nearest key is `flow_exponent`");
}

#[test]
fn flags_that_do_not_exist_or_lack_a_value_exit_with_2() {
    let folder = tempfile::tempdir().unwrap();
    for line in [
        "",
        "simulat",
        "simulate --sed 3",
        "simulate --disturbance 1,2",
        "simulate --out o.txt",
        "compare run.csv",
        "replay",
    ] {
        let output = lab(folder.path(), line);
        assert_eq!(output.status.code(), Some(2), "{line}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{line}");
    }
}

#[test]
fn every_scenario_simulates_writes_and_replays() {
    let folder = folder();
    fs::write(folder.path().join("reference.csv"), "t_s,reference_rad\n0,0\n0.1,0.3\n0.4,0.3\n").unwrap();
    let scenarios = ["step", "steps", "multisine", "chirp", "ramp", "disturbance", "--reference reference.csv"];
    for (k, scenario) in scenarios.into_iter().enumerate() {
        let file = format!("{k}.{}", if k % 2 == 0 { "csv" } else { "parquet" });
        let line = format!("simulate {scenario} --machine controlled.toml --duration-s 0.8 --seed 4 --out {file}");
        let summary = printed(folder.path(), &line);
        let rows = if scenario.starts_with("--") { 801 } else { 1600 };
        assert!(summary.starts_with(&format!("wrote {file}: {rows} rows, seed 4\n")), "{summary}");
        assert!(summary.contains("\npeak field ") && summary.contains("\ntime "), "{summary}");
        let replayed = printed(folder.path(), &format!("replay --machine controlled.toml {file}"));
        assert_eq!(replayed, format!("{file}: identical, {rows} rows\n"));
    }
}

#[test]
fn compare_writes_a_picture() {
    let folder = folder();
    let text = printed(folder.path(), "compare --machine machine.toml run.csv");
    assert!(text.starts_with("run.csv: 600 rows, 0.299 s, 0 gaps\n"), "{text}");
    let svg = fs::read_to_string(folder.path().join("compare-run.svg")).unwrap();
    assert!(svg.contains("<svg") && svg.contains("time (s)"));
    assert!(svg.contains("recorded") && svg.contains("nominal") && !svg.contains("improved"));
}

#[test]
fn compare_draws_an_improved_model_beside_the_other() {
    let folder = folder();
    fs::write(folder.path().join("poor.toml"), MACHINE.replace("coulomb = 0.763", "coulomb = 0.3")).unwrap();
    // Long enough for means over speed.
    printed(folder.path(), "simulate steps --machine machine.toml --duration-s 4 --out long.csv");
    let text = printed(folder.path(), "compare --machine poor.toml --improved machine.toml long.csv");
    assert!(text.contains("\nthe improved model:\n  50 ms windows  residual "), "{text}");
    let svg = fs::read_to_string(folder.path().join("compare-long.svg")).unwrap();
    for name in ["recorded", "nominal", "improved", "nominal, 95 %", "improved, 95 %", "nominal, one window"] {
        assert!(svg.contains(name), "{name}");
    }
    refused(
        folder.path(),
        "compare --machine machine.toml --improved linear.toml run.csv",
        "linear.toml: axis.kind: linear",
    );
}

#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation; the tests in release run it")]
fn demo_names_what_its_model_leaves_out() {
    let folder = folder();
    let text = printed(folder.path(), "demo --out demo");
    for file in ["step.svg", "machine.toml", "steps.csv", "compare.svg", "diagnosis.html"] {
        assert!(text.contains(file) && folder.path().join("demo").join(file).is_file(), "{file}: {text}");
    }
    assert!(text.contains("This is missing from the model:"), "{text}");
    for effect in ["viscous_friction: ", "field_dead_time: ", "field_lag: "] {
        assert!(text.contains(effect), "{effect}: {text}");
    }
    assert!(printed(folder.path(), "replay demo/steps.csv").ends_with("identical, 10000 rows\n"));
}

#[test]
fn columns_the_format_does_not_know_and_missing_rows_are_reported() {
    let folder = folder();
    let run = fs::read_to_string(folder.path().join("run.csv")).unwrap();
    let noted = run.lines().enumerate().filter(|(line, _)| *line != 50);
    let noted: String =
        noted.map(|(line, row)| format!("{row},{}\n", if line == 0 { "humidity" } else { "3" })).collect();
    fs::write(folder.path().join("noted.csv"), noted).unwrap();
    for line in ["replay noted.csv", "compare --machine machine.toml noted.csv"] {
        let text = printed(folder.path(), line);
        assert!(
            text.contains("note: noted.csv: column `humidity` is not one of the format and is not used\n"),
            "{text}"
        );
        assert!(
            text.contains(
                "note: noted.csv: rows are missing in 1 place, the first after row 49, 0.024 s after the start\n"
            ),
            "{text}"
        );
    }
}

/// Compares with a file under `tests/golden`, or rewrites it: `cargo xtask golden`.
fn golden(name: &str, text: &str) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if std::env::var_os("UPDATE_GOLDEN").is_some_and(|value| value == "1") {
        fs::write(&file, text).unwrap();
    }
    let expected = fs::read_to_string(&file).unwrap();
    assert_eq!(text, expected, "{name}; if the change is meant, `cargo xtask golden` rewrites it");
}

#[test]
fn the_summaries_are_those_of_the_golden_file() {
    let folder = tempfile::tempdir().unwrap();
    let lines = [
        "simulate",
        "simulate --fluid none",
        "simulate --fluid e --dead-time-ms 5",
        "simulate --fluid q --lag-ms 5",
        "simulate steps --seed 3 --sensor-noise-rad 1e-5 --torque-noise-nm 0.05",
        "simulate multisine --amplitude-deg 10",
        "simulate disturbance --drive-delay-ms 4.4",
    ];
    let text: String =
        lines.iter().map(|line| format!("$ servo-lab {line}\n{}\n", printed(folder.path(), line))).collect();
    golden("summaries.txt", &text);
}
