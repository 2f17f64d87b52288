//! Logs on which the tool once panicked, hung or refused without a reason.

use std::fs;
use std::path::Path;

use crate::common::{self, shared};

/// Exit code, standard output and standard error of a command; none for the code where it took more than a minute of processor.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = common::run(folder, arguments).output;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// Every so many rows of a file, at most so many.
fn thinned(from: &Path, to: &Path, every: usize, rows: usize) {
    let text = fs::read_to_string(from).unwrap();
    let mut lines = text.lines();
    let header = lines.next().unwrap().to_owned();
    let kept: Vec<&str> = lines.step_by(every).take(rows).collect();
    fs::write(to, format!("{header}\n{}\n", kept.join("\n"))).unwrap();
}

#[test]
fn a_load_in_its_gap_is_filtered_at_coarse_sampling() {
    let Some(data) = shared() else { return };
    let folder = tempfile::tempdir().unwrap();
    let machine = data.join("emps/machine.toml");
    for every in [3, 4, 8, 16] {
        thinned(&data.join("emps/train.csv"), &folder.path().join("thin.csv"), every, usize::MAX);
        let arguments = ["diagnose", "--machine", machine.to_str().unwrap(), "--only", "backlash", "thin.csv"];
        let (code, _, errors) = run(folder.path(), &arguments);
        assert_eq!(code, Some(0), "every row number {every}: {errors}");
    }
}

#[test]
fn a_few_rows_and_times_in_ms_are_refused_with_the_reason() {
    let Some(data) = shared() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (machine, train) = (data.join("emps/machine.toml"), data.join("emps/train.csv"));
    let file = folder.path().join("cut.csv");
    let arguments = ["diagnose", "--machine", machine.to_str().unwrap(), "cut.csv"];
    for rows in [2, 3, 5, 10, 20] {
        thinned(&train, &file, 1, rows);
        let (code, _, errors) = run(folder.path(), &arguments);
        assert!(code == Some(2) && errors.lines().count() == 1, "{rows} rows: {code:?}: {errors}");
    }
    let text = fs::read_to_string(&train).unwrap();
    let in_ms = |line: &str| {
        let (t_s, rest) = line.split_once(',').unwrap();
        t_s.parse::<f64>().map_or_else(|_| line.to_owned(), |t_s| format!("{},{rest}", 1e3 * t_s))
    };
    fs::write(&file, text.lines().map(in_ms).collect::<Vec<_>>().join("\n")).unwrap();
    let (code, _, errors) = run(folder.path(), &arguments);
    assert!(code == Some(2) && errors.lines().count() == 1, "times in ms: {code:?}: {errors}");
}

#[test]
fn a_robot_with_and_without_its_friction_gets_an_answer() {
    let Some(data) = shared() else { return };
    let weigand = data.join("weigand");
    for (machine, recording) in [("j1_no_friction", "j1_A"), ("j6_full", "j6_B")] {
        let machine = weigand.join(format!("{machine}.toml"));
        let recording = weigand.join(format!("{recording}.csv"));
        let arguments = ["diagnose", "--only", "backlash,compliance,coulomb_friction,viscous_friction", "--machine"];
        let files = [machine.to_str().unwrap(), recording.to_str().unwrap()];
        let (code, _, errors) = run(&weigand, &[arguments.as_slice(), &files].concat());
        assert_eq!(code, Some(0), "{files:?}: {errors}");
    }
}

const SERVO: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\nresolution = 1.3e-5\n\
                     [plant]\ninertia = 0.075\ncoulomb = 0.763\ntorque_limit = 30.0\ntorque_delay_s = 0.005\n";

#[test]
fn an_axis_that_never_moved_is_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), SERVO).unwrap();
    let made = run(folder.path(), &["simulate", "step", "--amplitude-deg", "0", "-o", "still.csv"]);
    assert_eq!(made.0, Some(0), "{}", made.2);
    let (code, _, errors) = run(folder.path(), &["diagnose", "--machine", "m.toml", "still.csv"]);
    assert!(matches!(code, Some(0 | 2)), "{code:?}: {errors}");
}

/// A loop of 2 kHz whose log holds every tenth row: friction and delays that no machine had were named for the commands between.
#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation; the tests in release run it")]
fn commands_that_the_log_does_not_hold_are_no_effect_of_the_machine() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), SERVO).unwrap();
    for (scenario, verdicts) in [("steps", ["ambiguous", "unknown"]), ("multisine", ["ambiguous", "none"])] {
        let simulated = ["simulate", scenario, "--machine", "m.toml", "--duration-s", "6", "--torque-noise-nm", "0.02"];
        let made = run(folder.path(), &[&simulated[..], &["--force", "-o", "run.csv"]].concat());
        assert_eq!(made.0, Some(0), "{}", made.2);
        let text = fs::read_to_string(folder.path().join("run.csv")).unwrap();
        // Without the counter of rows, which would tell of a gap after each.
        let row = |line: &str| line.split(',').take(4).collect::<Vec<_>>().join(",");
        let (header, rows) = text.split_once('\n').unwrap();
        let thin: Vec<String> = std::iter::once(header).chain(rows.lines().step_by(10)).map(row).collect();
        fs::write(folder.path().join("thin.csv"), thin.join("\n") + "\n").unwrap();
        let (code, out, errors) = run(folder.path(), &["diagnose", "--machine", "m.toml", "thin.csv", "--json", "-"]);
        assert_eq!(code, Some(0), "{errors}");
        let answer: serde_json::Value = serde_json::from_str(&out).unwrap();
        let verdict = answer["verdict"].as_str().unwrap();
        assert!(verdicts.contains(&verdict), "{scenario}: {out}");
        let warned =
            answer["warnings"].as_array().unwrap().iter().any(|one| {
                one.as_str().unwrap().contains("rows are 0.005 s apart and the loop has a tick every 0.0005 s")
            });
        assert!(warned, "{scenario}: {out}");
        for effect in answer["effects"].as_array().unwrap() {
            assert!(effect["nuisances"].to_string().contains("Commands between the rows"), "{effect}");
        }
    }
}

/// What is said of a model that takes more work than a comparison has.
const TOO_STIFF: &str = "the model is too stiff to follow along so many rows";

/// A thousand million times the drive's torque: it swings the rotor within less than a step.
const COGGING: &str = "[[effects]]\nid = \"cogging\"\namplitude_nm = 1e12\norder_per_rev = 7.0\nphase_rad = 0.0\n";

/// A machine with a fluid, for what only a rotary axis has.
const ER: &str = "[plant.er]\na = 0.0704\nb = 0.470\ndead_time_s = 0.002\nlag_s = 0.003\n";

/// Drag that stops the axis within a nanosecond, a bristle, a shaft and a gap that bend for as long: 1e12 steps and more, as long
/// as a step had to be shorter than that. A minute of processor is the limit
/// of any command.
#[test]
fn a_machine_however_stiff_costs_no_more_than_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |amplitude: f64| -> String {
        let row = |row| {
            let t_s = f64::from(row) * 0.005;
            format!("{t_s},{},{}\n", 0.1 * (3.0 * t_s).sin(), amplitude * (3.0 * t_s).cos())
        };
        (0..600).map(row).collect()
    };
    fs::write(folder.path().join("linear.csv"), format!("t_s,position_m,force_cmd_n\n{}", rows(520.0))).unwrap();
    fs::write(folder.path().join("rotary.csv"), format!("t_s,position_rad,torque_cmd_nm\n{}", rows(2.6))).unwrap();
    let drag = SERVO.replace("rotary", "linear").replace("0.075", "1e-6").replace("0.763", "0.1");
    let drag = drag.replace("torque_limit = 30.0", "viscous = 1724.0");
    let (stiff, servo) = (|effect: &str| format!("{drag}{effect}"), |effect: &str| format!("{SERVO}{ER}{effect}"));
    let shaft = |id: &str, resonance: &str, gap: &str| {
        servo(&format!(
            "[[effects]]\nid = \"{id}\"\nresonance_hz = {resonance}\ndamping_ratio = 0.03\ninertia_ratio = 0.5\n{gap}"
        ))
    };
    let machines = [
        ("linear", "drag", stiff("")),
        ("linear", "drag behind a lag", stiff("[[effects]]\nid = \"torque_lag\"\nlag_s = 0.002\n")),
        ("linear", "drag", stiff("[[effects]]\nid = \"quadratic_drag\"\ncoefficient_n_s2_m2 = 1.0\n")),
        ("rotary", "bristle", servo("[[effects]]\nid = \"presliding\"\nstiffness_nm_rad = 1e9\n")),
        ("rotary", "fluid", servo("[[effects]]\nid = \"er_preyield\"\nstiffness_nm_rad = 1e9\n")),
        ("rotary", "shaft", shaft("compliance", "1e3", "")),
        ("rotary", "shaft", shaft("compliance", "1e4", "")),
        ("rotary", "gap", shaft("backlash", "1e3", "gap_rad = 1e-9\n")),
        ("rotary", "gap", shaft("backlash", "1e3", "gap_rad = 1e-4\n")),
        ("rotary", TOO_STIFF, shaft("backlash", "1e4", "gap_rad = 1e-9\n")),
    ];
    for (axis, name, machine) in machines {
        fs::write(folder.path().join("m.toml"), machine).unwrap();
        let ended = common::run(folder.path(), &["compare", "--machine", "m.toml", &format!("{axis}.csv")]);
        println!("{name}: {:.2} s, {:.2} s of processor", ended.wall_s, ended.cpu_s);
        assert_eq!(ended.fault(), None, "{name}");
        let errors = String::from_utf8_lossy(&ended.output.stderr);
        assert!(ended.output.status.success() || name == TOO_STIFF && errors.contains(TOO_STIFF), "{name}: {errors}");
    }
}

/// A cogging of a billion times the drive's torque: an answer, or what to look at, within the minute.
#[test]
fn a_model_that_is_too_stiff_to_follow_is_refused_with_what_to_check() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), format!("{SERVO}{COGGING}")).unwrap();
    let row = |row| {
        let t_s = f64::from(row) * 0.02;
        format!("{t_s},{},{}\n", 0.1 * (3.0 * t_s).sin(), 2.6 * (3.0 * t_s).cos())
    };
    let rows: String = (0..60).map(row).collect();
    fs::write(folder.path().join("run.csv"), format!("t_s,position_rad,torque_cmd_nm\n{rows}")).unwrap();
    let ended = common::run(folder.path(), &["compare", "--machine", "m.toml", "run.csv"]);
    println!("{:.2} s of processor: {}", ended.cpu_s, String::from_utf8_lossy(&ended.output.stderr));
    assert_eq!(ended.fault(), None);
}

/// Numbers that no machine has, on which plant and search once panicked or ran for ever.
#[test]
fn numbers_that_no_machine_has_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (from, to) in [("0.075", "5e-324"), ("0.075", "1e-300"), ("0.075", "1e300"), ("0.763", "1.7e308")] {
        fs::write(folder.path().join("m.toml"), SERVO.replace(from, to)).unwrap();
        for command in ["simulate", "tune", "stability"] {
            let (code, _, errors) = run(folder.path(), &[command, "--machine", "m.toml"]);
            assert!(code == Some(2) && errors.contains("of a size from 1e-15 to 1e15"), "{command} {to}: {errors}");
        }
    }
    // Within the range and far too stiff.
    fs::write(folder.path().join("m.toml"), SERVO.replace("coulomb = 0.763", "viscous = 1e12")).unwrap();
    let (code, _, errors) = run(folder.path(), &["tune", "--machine", "m.toml"]);
    assert!(code == Some(2) && errors.contains("the loop is too stiff to tune"), "{code:?}: {errors}");
}
