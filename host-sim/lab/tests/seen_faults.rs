//! Logs on which the tool once panicked, hung or refused without a reason.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use assert_cmd::Command;

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

/// Exit code, standard output and standard error of a command; none for the code where it did not end within a minute.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::cargo_bin("servo-lab").unwrap();
    let output = command.current_dir(folder).args(arguments).timeout(Duration::from_secs(60)).output().unwrap();
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

/// Drag that stops the axis within a nanosecond, on 3 s at 5 ms: 1e12 steps, as long as a step had to be shorter than that.
#[test]
fn drag_that_is_stiff_against_the_inertia_costs_no_more_than_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let rows: Vec<String> = (0..600)
        .map(|row| {
            let t_s = f64::from(row) * 0.005;
            format!("{t_s},{},{}", 0.1 * (3.0 * t_s).sin(), 520.0 * (3.0 * t_s).cos())
        })
        .collect();
    fs::write(folder.path().join("run.csv"), format!("t_s,position_m,force_cmd_n\n{}\n", rows.join("\n"))).unwrap();
    let lag = "[[effects]]\nid = \"torque_lag\"\nlag_s = 0.002\n";
    let drag = "[[effects]]\nid = \"quadratic_drag\"\ncoefficient_n_s2_m2 = 1.0\n";
    for effect in ["", lag, drag] {
        let machine = SERVO.replace("rotary", "linear").replace("0.075", "1e-6").replace("0.763", "0.1");
        let machine = machine.replace("torque_limit = 30.0", "viscous = 1724.0");
        fs::write(folder.path().join("m.toml"), format!("{machine}{effect}")).unwrap();
        let (code, _, errors) = run(folder.path(), &["compare", "--machine", "m.toml", "run.csv"]);
        assert_eq!(code, Some(0), "{effect}: {errors}");
    }
}
