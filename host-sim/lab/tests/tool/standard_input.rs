//! Logs that come through standard input.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

const MACHINE: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 1e-3\nresolution = 1.3e-5\n\
                       [plant]\ninertia = 0.075\ncoulomb = 0.763\ntorque_limit = 30.0\ntorque_delay_s = 0.005\n";

fn lab(folder: &Path, words: &[&str], input: &[u8]) -> String {
    let mut command = Command::cargo_bin("servo-lab").unwrap();
    let output = command.current_dir(folder).args(words).write_stdin(input).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// An axis with more friction than its machine file says.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), MACHINE).unwrap();
    fs::write(folder.path().join("real.toml"), MACHINE.replace("0.763", "1.2")).unwrap();
    let words = ["simulate", "steps", "--machine", "real.toml", "--duration-s", "1.5", "--torque-noise-nm", "0.02"];
    for file in ["run.csv", "run.parquet"] {
        lab(folder.path(), &[&words[..], &["-o", file]].concat(), b"");
    }
    folder
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_diagnosis_of_standard_input_is_that_of_the_file() {
    let folder = folder();
    let answer = |file: &str, input: &[u8]| -> Value {
        let mut answer: Value =
            serde_json::from_str(&lab(folder.path(), &["diagnose", "--machine", "m.toml", file, "--json", "-"], input))
                .unwrap();
        // Which file it was is all that may differ.
        answer.as_object_mut().unwrap().remove("provenance").unwrap();
        for location in answer["locations"].as_array_mut().unwrap() {
            assert_eq!(location["recording"], file);
            location.as_object_mut().unwrap().remove("recording");
        }
        answer
    };
    let named = answer("run.csv", b"");
    assert_eq!(named["effects"][0]["id"], "coulomb_friction", "{named:#}");
    for kind in ["run.csv", "run.parquet"] {
        assert_eq!(answer("-", &fs::read(folder.path().join(kind)).unwrap()), named, "{kind}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_comparison_of_standard_input_is_that_of_the_file() {
    let folder = folder();
    let compared = |file: &str, plots: &str, input: &[u8]| {
        let text = lab(folder.path(), &["compare", "--machine", "m.toml", file, "--plots", plots], input);
        let lines = text.lines().filter(|line| !line.starts_with("wrote"));
        lines.collect::<Vec<_>>().join("\n").replacen(file, "LOG", 1)
    };
    let named = compared("run.csv", "named", b"");
    assert!(named.contains("as a torque"), "{named}");
    assert_eq!(compared("-", "piped", &fs::read(folder.path().join("run.csv")).unwrap()), named);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_measured_step_of_the_paper_is_read_by_the_columns_of_a_machine_file() {
    let folder = tempfile::tempdir().unwrap();
    lab(folder.path(), &["simulate", "step", "--duration-s", "0.4", "-o", "step.csv"], b"");
    let own = fs::read_to_string(folder.path().join("step.csv")).unwrap();
    // The same in milliseconds and degrees, under names of its own.
    let mut rows = own.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = rows.next().unwrap().split(',').collect();
    let place = |name: &str| names.iter().position(|found| *found == name).unwrap();
    let [t_s, position, torque] = ["t_s", "position_rad", "torque_cmd_nm"].map(place);
    let mut raw = String::from("ms,angle,u\n");
    for row in rows {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap_or(0.0)).collect();
        raw += &format!("{:.3},{:.9},{}\n", 1e3 * cells[t_s], cells[position].to_degrees(), cells[torque]);
    }
    fs::write(folder.path().join("raw.csv"), raw).unwrap();
    let columns = "[columns]\ntime = { name = \"ms\", unit = \"ms\" }\nposition = { name = \"angle\", unit = \"deg\" }\n\
                   torque = { name = \"u\" }\n";
    fs::write(folder.path().join("m.toml"), format!("{MACHINE}{columns}")).unwrap();
    lab(folder.path(), &["paper", "--measured", "raw.csv", "--machine", "m.toml", "--out", "mapped"], b"");
    lab(folder.path(), &["paper", "--measured", "step.csv", "--out", "own"], b"");
    let figures = |out: &str| {
        let files = fs::read_dir(folder.path().join(out)).unwrap().map(|entry| entry.unwrap().path());
        let mut files: Vec<_> = files.filter(|file| file.extension().is_some_and(|end| end == "svg")).collect();
        files.sort();
        files.iter().map(|file| fs::read_to_string(file).unwrap()).collect::<Vec<_>>()
    };
    let drawn = |out: &str| figures(out).iter().filter(|figure| figure.contains("measured")).count();
    assert!(drawn("mapped") > 0 && drawn("mapped") == drawn("own"));
    let refused = Command::cargo_bin("servo-lab").unwrap().args(["paper", "--machine", "m.toml"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2), "a machine file says nothing without a recording");
}
