//! `servo-lab fleet` as a user runs it: a manifest of short recordings, one bad row, a run that goes on.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Output;
use std::thread;
use std::time::{Duration, Instant};

use assert_cmd::Command;
use lab::fleet::{Row, Task, manifest, table};
use lab::output::Files;
use lab::read::Table;

const MACHINE: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 1e-3\nresolution = 1.3e-5\n\
                       [plant]\ninertia = 0.075\ncoulomb = 0.763\ntorque_limit = 30.0\ntorque_delay_s = 0.005\n";

fn lab(folder: &Path, words: &[&str]) -> Output {
    Command::cargo_bin("servo-lab").unwrap().current_dir(folder).args(words).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Two recordings of each of two dates, a second and a half each; on the second day the axis is stiffer.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("axis")).unwrap();
    fs::write(at("axis/m.toml"), MACHINE).unwrap();
    for (day, coulomb_nm) in [("mon", "1.0"), ("tue", "1.5")] {
        fs::write(at("real.toml"), MACHINE.replace("coulomb = 0.763", &format!("coulomb = {coulomb_nm}"))).unwrap();
        for seed in ["1", "2"] {
            let file = format!("axis/{day}{seed}.csv");
            let simulate = ["simulate", "steps", "--machine", "real.toml", "--duration-s", "1.5", "--dwell-s", "0.3"];
            let noise = ["--torque-noise-nm", "0.02", "--seed", seed, "-o", &file];
            let made = lab(folder.path(), &[&simulate[..], &noise].concat());
            assert!(made.status.success(), "{}", text(&made.stderr));
        }
    }
    folder
}

const GOOD: &str = "machine,recordings,holdout,date\naxis/m.toml,axis/mon1.csv,axis/mon2.csv,2026-03-30\n\
                    axis/m.toml,axis/tue1.csv;axis/tue2.csv,,2026-03-31\n";

/// The columns of a table by their names.
fn columns(file: &Path) -> BTreeMap<String, Vec<String>> {
    Table::words(file).unwrap().into_iter().collect()
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_fleet_is_diagnosed_row_by_row_and_goes_on_where_it_was_stopped() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("good.csv"), GOOD).unwrap();
    // The second row names a file that is not there; the rows around it are diagnosed all the same.
    let mut lines: Vec<&str> = GOOD.lines().collect();
    lines.insert(2, "axis/m.toml,axis/missing.csv,,2026-03-30");
    fs::write(at("bad.csv"), lines.join("\n") + "\n").unwrap();
    let run = |manifest: &str| lab(folder.path(), &["fleet", manifest, "-o", "fleet.parquet", "--html", "fleet.html"]);
    let first = run("bad.csv");
    let errors = text(&first.stderr);
    assert_eq!(first.status.code(), Some(2), "{errors}");
    assert!(errors.starts_with("error: bad.csv:3: axis/missing.csv: ") && errors.lines().count() == 1, "{errors}");
    let rows = columns(&at("fleet.parquet"));
    assert_eq!(rows["line"], ["2", "3", "4"]);
    assert!(rows["error"][1].contains("missing.csv") && rows["error"][0].is_empty() && rows["error"][2].is_empty());
    assert!(
        rows["effects"][0].contains("coulomb_friction") && rows["effects"][2].contains("coulomb_friction"),
        "{rows:?}"
    );
    assert_eq!(rows["heldout_after_rms"][1], "NaN");
    let out = text(&first.stdout);
    assert!(out.contains("coulomb_nm, N m") && out.contains("beyond both intervals"), "{out}");
    let page = fs::read_to_string(at("fleet.html")).unwrap();
    assert!(
        page.contains("Drift over dates") && page.contains("axis/missing.csv") && page.contains("Written by servo-lab")
    );

    // The second run goes on with the table of the first.
    let answers = rows["answer"].clone();
    let again = run("good.csv");
    assert_eq!(again.status.code(), Some(0), "{}", text(&again.stderr));
    let second = columns(&at("fleet.parquet"));
    assert_eq!(second["line"], ["2", "3"], "the bad row is gone from the manifest, and from the table");
    assert_eq!(second["answer"], [answers[0].clone(), answers[2].clone()]);
    fs::remove_file(at("axis/mon2.csv")).unwrap();
    let lost = run("good.csv");
    assert!(text(&lost.stderr).contains("good.csv:2: axis/mon2.csv: "), "{}", text(&lost.stderr));
    assert_eq!(columns(&at("fleet.parquet"))["answer"][1], answers[2]);
}

/// Puts a mark into the answers of a table, which a run that does them again has not.
fn mark(manifest: &Path, table: &Path) -> usize {
    let (tasks, earlier) = (manifest::read(manifest).unwrap(), table::earlier(table).unwrap());
    let marked = |task: Task| {
        let key = task.key().unwrap();
        let mut answer = earlier.get(&key)?.clone();
        answer.warnings.push("kept".to_owned());
        Some(Row { task, key, outcome: Ok(answer) })
    };
    let rows: Vec<Row> = tasks.into_iter().filter_map(marked).collect();
    let mut files = Files::new(true);
    let written = files.writes(table);
    let mut outputs = files.check().unwrap();
    table::write(&mut outputs, written, &rows.iter().collect::<Vec<_>>()).unwrap();
    rows.len()
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_run_that_is_killed_midway_goes_on_with_the_rows_that_were_done() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let all = ["mon1", "mon2", "tue1"];
    let pairs = all.iter().flat_map(|one| all.iter().filter(move |other| *other != one).map(move |other| (one, other)));
    let rows: String = pairs.map(|(one, other)| format!("axis/m.toml,axis/{one}.csv,axis/{other}.csv\n")).collect();
    fs::write(at("many.csv"), format!("machine,recordings,holdout\n{rows}")).unwrap();
    let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin("servo-lab"));
    let words = ["fleet", "many.csv", "-o", "fleet.parquet", "--jobs", "1"];
    let mut child = command.current_dir(folder.path()).args(words).spawn().unwrap();
    let begun = Instant::now();
    while fs::metadata(at("fleet.parquet")).map_or(0, |file| file.len()) == 0 {
        assert!(begun.elapsed() < Duration::from_secs(120), "no row was saved");
        thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let done = mark(&at("many.csv"), &at("fleet.parquet"));
    println!("{done} of 6 rows were done");
    assert!((1..6).contains(&done), "{done} of 6");
    let again = lab(folder.path(), &words);
    assert_eq!(again.status.code(), Some(0), "{}", text(&again.stderr));
    let second = columns(&at("fleet.parquet"));
    assert_eq!(second["line"].len(), 6);
    assert!(second["error"].iter().all(String::is_empty), "{:?}", second["error"]);
    assert_eq!(second["warnings"].iter().filter(|text| text.contains("kept")).count(), done);
}

#[test]
fn a_manifest_or_a_table_that_is_none_is_refused_before_the_computing() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("m.toml"), MACHINE).unwrap();
    fs::write(at("notes.parquet"), "mine").unwrap();
    let refused = |manifest: &str, out: &str, message: &str| {
        fs::write(at("manifest.csv"), manifest).unwrap();
        let output = lab(folder.path(), &["fleet", "manifest.csv", "-o", out]);
        let errors = text(&output.stderr);
        assert!(output.status.code() == Some(2) && errors.contains(message), "{manifest:?}: {errors}");
        assert_eq!(errors.lines().count(), 1, "{errors}");
    };
    let good = "machine,recordings\nm.toml,a.csv\n";
    refused(
        "machine,recording\nm.toml,a.csv\n",
        "t.parquet",
        "recording: unknown column; a manifest has machine, recordings",
    );
    refused("machine,date\nm.toml,2026-01-01\n", "t.parquet", "must have the columns machine and recordings");
    refused("machine,recordings\n", "t.parquet", "there is no row to diagnose");
    refused(good, "t.csv", "the name of the table must end in .parquet");
    refused(good, "notes.parquet", "servo-lab did not write it");
    refused(good, "t.parquet", "manifest.csv:2: a.csv: ");
    refused(
        "machine,recordings,date\nm.toml,a.csv,monday\n",
        "t.parquet",
        "date: `monday` is no date as 2026-03-31 is",
    );
    refused("machine,recordings\nm.toml,\n", "t.parquet", "recordings: the cell is empty");
    // A recording of its own is no table of a fleet, and stays.
    let simulated = lab(folder.path(), &["simulate", "--duration-s", "0.1", "-o", "run.parquet"]);
    assert!(simulated.status.success(), "{}", text(&simulated.stderr));
    let before = fs::read(at("run.parquet")).unwrap();
    refused(good, "run.parquet", "run.parquet: is no table of a fleet");
    assert_eq!(fs::read(at("run.parquet")).unwrap(), before);
}
