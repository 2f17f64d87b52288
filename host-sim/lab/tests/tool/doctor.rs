//! What `doctor` says of the time in a log: columns that are late, jitter beside a gap, a rate or a length that no diagnosis takes.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use assert_cmd::Command;

const MACHINE: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\nresolution = 1.3e-5\n\
                       [plant]\ninertia = 0.075\ncoulomb = 0.763\ntorque_limit = 30.0\n";
/// Period of the simulated logs, ms.
const PERIOD_MS: f64 = 0.5;

fn lab(folder: &Path, words: &[&str]) -> String {
    let output = Command::cargo_bin("servo-lab").unwrap().current_dir(folder).args(words).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The line of `doctor` that begins so, with its state before it.
fn line<'a>(looked: &'a str, what: &str) -> Option<&'a str> {
    looked.lines().find(|line| line.get(6..).is_some_and(|line| line.starts_with(what)))
}

/// Time, position and torque, as they are written, of a simulation on an axis without delay.
fn simulated(folder: &Path, scenario: &str) -> Vec<[String; 3]> {
    fs::write(folder.join("m.toml"), MACHINE).unwrap();
    let flags = ["--machine", "m.toml", "--duration-s", "6", "--torque-noise-nm", "0.05", "-o", "run.csv", "--force"];
    lab(folder, &[&["simulate", scenario][..], &flags].concat());
    let text = fs::read_to_string(folder.join("run.csv")).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let places =
        ["t_s", "position_rad", "torque_cmd_nm"].map(|name| names.iter().position(|own| *own == name).unwrap());
    lines.map(|row| places.map(|place| row.split(',').nth(place).unwrap().to_owned())).collect()
}

/// One row of so many, with the torque late by so many rows of the simulation; early where they are below 0.
fn shifted(rows: &[[String; 3]], every: usize, late: isize) -> String {
    let mut text = String::from("t_s,position_rad,torque_cmd_nm\n");
    for at in (0..rows.len()).step_by(every) {
        let torque = &rows[at.saturating_add_signed(-late).min(rows.len() - 1)][2];
        let _ = writeln!(text, "{},{},{torque}", rows[at][0], rows[at][1]);
    }
    text
}

/// The first number of a text before this unit.
fn number_before(text: &str, unit: &str) -> (f64, String) {
    let word = text.split(unit).next().unwrap().split_whitespace().last().unwrap();
    (word.parse().unwrap(), word.to_owned())
}

/// A torque that is measured over a bus is late, one that a slow drive is commanded is early.
#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_torque_that_is_late_or_early_is_told_with_its_sign_and_size() {
    let folder = tempfile::tempdir().unwrap();
    for scenario in ["multisine", "steps"] {
        let rows = simulated(folder.path(), scenario);
        let at_each_row = [-20.0, -6.0, 0.0, 12.0].map(|ms| (1, ms));
        for (every, late_ms) in at_each_row.into_iter().chain([-12.0, 0.0, 6.0, 20.0].map(|ms| (4, ms))) {
            let late = (late_ms / PERIOD_MS) as isize;
            fs::write(folder.path().join("log.csv"), shifted(&rows, every, late)).unwrap();
            let looked = lab(folder.path(), &["doctor", "log.csv"]);
            let at = format!("{scenario}, one row of {every}, {late_ms} ms late: {looked}");
            let skew = line(&looked, "skew").unwrap();
            if late_ms == 0.0 {
                assert!(skew.starts_with("ok") && skew.contains("torque and motion go together"), "{at}");
                continue;
            }
            let column = if late_ms > 0.0 { "the column of the torque is about" } else { "the position is about" };
            assert!(skew.starts_with("note") && skew.contains(column), "{at}");
            let (told_ms, digits) = number_before(skew, " ms");
            // A command is held for a period, which is half a period late; and a row of the log is the step of what is told.
            let period_ms = PERIOD_MS * every as f64;
            assert!((told_ms - late_ms.abs()).abs() <= 1.5 * period_ms.max(1.0), "{at}");
            // No digits that the rows do not give.
            assert_eq!(digits.contains('.'), period_ms < 1.0, "{at}");
            assert!(!looked.contains("a sign is wrong"), "{at}");
        }
    }
}

#[test]
fn a_delay_that_the_machine_file_states_is_no_fault() {
    let folder = tempfile::tempdir().unwrap();
    let rows = simulated(folder.path(), "multisine");
    fs::write(folder.path().join("log.csv"), shifted(&rows, 1, -16)).unwrap();
    let stated = |delay: &str| {
        let file = MACHINE.replace("[plant]\n", &format!("[plant]\ntorque_delay_s = {delay}\n"));
        fs::write(folder.path().join("stated.toml"), file).unwrap();
        let looked = lab(folder.path(), &["doctor", "--machine", "stated.toml", "log.csv"]);
        line(&looked, "skew").unwrap().to_owned()
    };
    let right = stated("0.008");
    assert!(right.starts_with("ok") && right.contains("behind the torque, as the machine file says"), "{right}");
    let wrong = stated("0.001");
    assert!(wrong.starts_with("note") && wrong.contains("state torque_delay_s if the drive is so slow"), "{wrong}");
}

#[test]
fn a_gap_is_no_jitter_and_one_place_is_no_places() {
    let folder = tempfile::tempdir().unwrap();
    let mut rows = simulated(folder.path(), "steps");
    rows.drain(2000..2200);
    fs::write(folder.path().join("log.csv"), shifted(&rows, 1, 0)).unwrap();
    let looked = lab(folder.path(), &["doctor", "log.csv"]);
    assert!(line(&looked, "gaps").unwrap().contains("missing in 1 place, the first after row 2000,"), "{looked}");
    let jitter = line(&looked, "jitter").unwrap();
    assert!(jitter.starts_with("ok") && jitter.contains(" 0 % at most"), "{looked}");
}

#[test]
fn of_a_log_that_no_diagnosis_takes_it_is_not_said_what_would_be_seen() {
    let folder = tempfile::tempdir().unwrap();
    let rows = simulated(folder.path(), "steps");
    for (name, log, why) in [
        ("slow.csv", shifted(&rows, 150, 0), "too slow for any window of a motion: log at 20 Hz or more"),
        ("short.csv", shifted(&rows[..240], 1, 0), "0.12 s; too short: diagnose needs 0.8 s"),
    ] {
        fs::write(folder.path().join(name), log).unwrap();
        for more in [&[][..], &["--machine", "m.toml"]] {
            let looked = lab(folder.path(), &[&["doctor", name], more].concat());
            let rate = line(&looked, "rate").unwrap();
            assert!(rate.starts_with("BAD") && rate.contains(why), "{looked}");
            assert!(!looked.contains("would be seen") && !looked.contains("nothing moves enough"), "{looked}");
        }
    }
}
