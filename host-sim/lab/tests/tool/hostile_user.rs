//! Files and flags of a user who knows nothing of the tool: each is read, or refused with one message that says why.

use std::fs;
use std::path::Path;
use std::process::Output;
use std::time::Duration;

use assert_cmd::Command;

const MACHINE: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\n\
                       resolution = 1.2783173e-5\n[plant]\ninertia = 0.075\ncoulomb = 0.763\ntorque_limit = 30\n\
                       torque_delay_s = 0.005\n[plant.er]\na = 0.0704\nb = 0.470\ndead_time_s = 0.002\nlag_s = 0.003\n";

fn lab(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::cargo_bin("servo-lab").unwrap();
    command.current_dir(folder).args(words).timeout(Duration::from_secs(60)).output().unwrap()
}

fn done(folder: &Path, words: &[&str]) -> String {
    let output = lab(folder, words);
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Exit code 2 and one line that holds `message`.
fn refused(folder: &Path, words: &[&str], message: &str) {
    let output = lab(folder, words);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{words:?}: {errors}");
    assert!(errors.lines().count() == 1 && errors.contains(message), "{words:?} lacks {message:?}: {errors}");
}

/// A folder with a machine file, and a recording of a second as its text.
fn folder() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), MACHINE).unwrap();
    let words = ["simulate", "steps", "--machine", "m.toml", "--duration-s", "1", "--torque-noise-nm", "0.02"];
    done(folder.path(), &[&words[..], &["-o", "run.csv"]].concat());
    let text = fs::read_to_string(folder.path().join("run.csv")).unwrap();
    (folder, text)
}

/// The text with a column changed, row by row from 0.
fn with_column(text: &str, name: &str, change: impl Fn(usize, &str) -> String) -> String {
    let mut lines = text.lines();
    let header = lines.next().unwrap();
    let place = header.split(',').position(|column| column.trim_matches('"') == name).unwrap();
    let row = |(row, line): (usize, &str)| {
        let cell = |(index, cell): (usize, &str)| if index == place { change(row, cell) } else { cell.to_owned() };
        line.split(',').enumerate().map(cell).collect::<Vec<_>>().join(",")
    };
    let rows: Vec<String> = lines.enumerate().map(row).collect();
    format!("{header}\n{}\n", rows.join("\n"))
}

#[test]
fn texts_of_other_programs_are_read_or_named() {
    let (folder, text) = folder();
    let file = folder.path().join("log.csv");
    let compare = ["compare", "--machine", "m.toml", "log.csv"];
    for readable in [
        format!("\u{feff}{text}"),
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        text.replace('\n', "\n\n"),
        text.replace(',', ";"),
        text.replace(',', "\t"),
    ] {
        fs::write(&file, readable).unwrap();
        done(folder.path(), &compare);
    }
    let utf16: Vec<u8> = std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let double = text.replacen("reference_rad", "position_rad", 1);
    let (half, repeated) = (text[..text.len() / 2].trim_end().to_owned(), format!("{text}{text}"));
    let cases: [(&[u8], &str); 8] = [
        (&utf16, "log.csv: is UTF-16 text; save it as UTF-8"),
        (b"", "log.csv: the file is empty"),
        (text.lines().next().unwrap().as_bytes(), "log.csv"),
        (double.as_bytes(), "position_rad: column is there twice, as column 2 and column 3"),
        (half.as_bytes(), "was the file cut short"),
        (repeated.as_bytes(), "the header is repeated here"),
        (b"PAR1 and then something else altogether PAR1", "is not a Parquet file that can be read"),
        (b"\x1f\x8b\x08\x00and then no gzip", "the gzip file is damaged or cut short"),
    ];
    for (bytes, message) in cases {
        fs::write(&file, bytes).unwrap();
        refused(folder.path(), &compare, message);
        let errors = String::from_utf8(lab(folder.path(), &["init", "log.csv", "-o", "new.toml"]).stderr).unwrap();
        assert!(errors.starts_with("error: log.csv") && errors.lines().count() == 1, "{message}: {errors}");
    }
    assert!(!folder.path().join("new.toml").exists());
}

#[test]
fn columns_without_numbers_and_times_that_run_back_are_named() {
    let (folder, text) = folder();
    let file = folder.path().join("log.csv");
    for bad in ["NaN", "inf", "", "n/a"] {
        for column in ["t_s", "position_rad", "torque_cmd_nm", "velocity_rad_s"] {
            fs::write(&file, with_column(&text, column, |_, _| bad.to_owned())).unwrap();
            for command in ["compare", "diagnose", "doctor"] {
                refused(folder.path(), &[command, "--machine", "m.toml", "log.csv"], &format!("log.csv:2: {column}: "));
            }
        }
    }
    let swapped = with_column(&text, "t_s", |row, cell| if row == 100 { "0.0495".to_owned() } else { cell.to_owned() });
    fs::write(&file, swapped).unwrap();
    refused(folder.path(), &["compare", "--machine", "m.toml", "log.csv"], "log.csv:102: t_s: time 0.0495 repeats");
}

/// A counter of rows rises too, and in its place every period and speed is wrong.
#[test]
fn a_time_that_is_broken_is_not_replaced_by_a_counter() {
    let (folder, text) = folder();
    let file = folder.path().join("log.csv");
    let init = ["init", "log.csv", "-o", "new.toml"];
    let at_row_100 =
        |stamp: &'static str| move |row: usize, cell: &str| if row == 100 { stamp } else { cell }.to_owned();
    fs::write(&file, with_column(&text, "t_s", at_row_100("0.0495"))).unwrap();
    refused(folder.path(), &init, "log.csv:102: t_s: time 0.0495 repeats");
    fs::write(&file, with_column(&text, "t_s", at_row_100("0.01"))).unwrap();
    refused(folder.path(), &init, "`t_s` does not rise from 0.0495 to 0.01, rows 100 and 101");
    fs::write(&file, with_column(&text, "t_s", |row, cell| if row == 7 { "NaN".into() } else { cell.into() })).unwrap();
    refused(folder.path(), &init, "`t_s` holds cells that are no finite numbers");
    fs::write(&file, text.lines().take(2).collect::<Vec<_>>().join("\n") + "\n").unwrap();
    refused(folder.path(), &init, "log.csv: one row tells nothing; record longer");
    assert!(done(folder.path(), &["doctor", "log.csv", "--machine", "m.toml"]).contains("one row tells nothing"));
    assert!(!folder.path().join("new.toml").exists());
}

#[test]
fn a_recording_is_not_held_out_of_itself() {
    let (folder, text) = folder();
    fs::write(folder.path().join("copy.csv"), text).unwrap();
    for words in [["run.csv", "--holdout", "run.csv"], ["run.csv", "--holdout", "copy.csv"]] {
        let words = [&["diagnose", "--machine", "m.toml"], &words[..]].concat();
        refused(folder.path(), &words, "its rows are those of another recording that is given");
    }
    refused(folder.path(), &["diagnose", "--machine", "m.toml", "run.csv", "copy.csv"], "copy.csv: its rows are those");
}

#[test]
fn folders_devices_and_names_in_any_script_are_files_like_others() {
    let (folder, text) = folder();
    let (inner, at) = ("ünï çødé 日本", folder.path());
    fs::create_dir_all(at.join(inner)).unwrap();
    fs::write(at.join(inner).join("läuf 1.csv"), &text).unwrap();
    fs::write(at.join(inner).join("mäschine.toml"), MACHINE).unwrap();
    let [log, machine, plots] = ["läuf 1.csv", "mäschine.toml", "bïlder"].map(|name| format!("{inner}/{name}"));
    done(at, &["compare", "--machine", &machine, &log, "--plots", &plots]);
    assert!(at.join(plots).join("compare-läuf 1.svg").is_file());
    for words in [["--machine", "m.toml", inner], ["--machine", inner, "run.csv"]] {
        refused(at, &[&["compare"], &words[..]].concat(), "Is a directory");
    }
    if cfg!(target_os = "linux") {
        for words in
            [&["simulate", "--duration-s", "0.1", "--plot", "/dev/full"][..], &["stability", "--json", "/dev/full"]]
        {
            refused(at, words, "/dev/full: cannot write: No space left on device");
        }
        // No file can be made there: the message names what the user named, not the temporary file.
        for words in [&["simulate", "-o", "/proc/run.csv"][..], &["stability", "--json", "/proc/a.json"]] {
            refused(at, words, "cannot write: No such file or directory (os error 2)\n");
        }
        refused(at, &["compare", "--machine", "m.toml", "/dev/null"], "/dev/null: the file is empty");
        refused(at, &["compare", "--machine", "/dev/null", "run.csv"], "/dev/null:1: schema: is missing");
    }
}

#[test]
fn numbers_of_threads_that_no_machine_has_are_refused() {
    let (folder, _) = folder();
    for (flag, count) in [("--jobs", "1000000"), ("--jobs", "0"), ("--jobs", "-1"), ("--jobs", "two")] {
        let output = lab(folder.path(), &["diagnose", "--machine", "m.toml", "run.csv", &format!("{flag}={count}")]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.code() == Some(2) && errors.contains("must be a whole number from 1 to 1024"),
            "{errors}"
        );
    }
    let output = lab(folder.path(), &["prove", "--case", "0", "--workers", "100000"]);
    assert_eq!(output.status.code(), Some(2));
}

/// Rows up to 50 ms apart are diagnosed, and `doctor` says so; a little more is refused by both.
#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation; the tests in release run it")]
fn doctor_and_diagnose_agree_on_how_slow_a_log_may_be() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("m.toml"), MACHINE).unwrap();
    let steps = ["simulate", "steps", "--machine", "m.toml", "--duration-s", "6", "--torque-noise-nm", "0.02"];
    done(folder.path(), &[&steps[..], &["-o", "run.csv"]].concat());
    let text = fs::read_to_string(at("run.csv")).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    for (every, reads) in [(32, true), (60, true), (100, true), (120, false)] {
        let thinned: Vec<&str> = std::iter::once(header).chain(rows.lines().step_by(every)).collect();
        fs::write(at("slow.csv"), thinned.join("\n") + "\n").unwrap();
        let diagnose = ["diagnose", "--machine", "m.toml", "--only", "viscous_friction", "slow.csv"];
        if reads {
            // The counter of rows says that each is alone between two gaps: nothing is left to judge by.
            refused(folder.path(), &diagnose, "s are needed; record without losing rows, or, of rows thinned out");
        }
        // Without the counter, and the other columns behind what is diagnosed, it is a slower log.
        let kept: Vec<String> =
            thinned.iter().map(|line| line.splitn(6, ',').take(5).collect::<Vec<_>>().join(",")).collect();
        fs::write(at("slow.csv"), kept.join("\n") + "\n").unwrap();
        let looked = done(folder.path(), &["doctor", "--machine", "m.toml", "slow.csv"]);
        let period_ms = 0.5 * every as f64;
        if reads {
            assert!(looked.contains("ok    rate"), "{period_ms} ms: {looked}");
            // Eight rows, where those are longer than 50 ms.
            let windows = format!("Windows of {} s, ", 8.0 * period_ms / 1e3);
            let answer = done(folder.path(), &diagnose);
            assert!(answer.contains(&windows), "{windows}: {answer}");
        } else {
            assert!(looked.contains("BAD   rate") && looked.contains("log at 20 Hz or more"), "{looked}");
            refused(folder.path(), &diagnose, "s apart, at most 0.05 s can be worked on");
        }
    }
}

/// A key or a column that is not known: the nearest of the whole schema, in the unit that is expected, and all at once.
#[test]
fn keys_and_columns_that_are_not_known_are_named_with_what_is_expected() {
    let (folder, text) = folder();
    let at = |name: &str| folder.path().join(name);
    let machine = |from: &str, to: &str| fs::write(at("other.toml"), MACHINE.replacen(from, to, 1)).unwrap();
    let compare = ["compare", "--machine", "other.toml", "run.csv"];
    for (from, to, message) in [
        ("name =", "inertia = 1\nname =", "other.toml:2: inertia: unknown key; the nearest key is `plant.inertia`"),
        ("kind =", "type = \"rotary\"\nkind =", "axis.type: unknown key; the nearest key is `kind`"),
        ("torque_delay_s = 0.005", "torque_delay_ms = 5", "`torque_delay_s`, in s: multiply the value by 0.001"),
        ("[axis]", "[machine]\n[axis]", "machine: unknown key; known here are `schema`, `name`, `axis`, `plant`"),
    ] {
        machine(from, to);
        refused(folder.path(), &compare, message);
    }
    machine("none", "none");
    for (from, to, message) in [
        ("t_s,", "t_ms,", "`t_ms` is in ms: multiply its values by 0.001 and call it `t_s`, in s"),
        ("position_rad", "position_deg", "`position_deg` is in deg: multiply its values by 0.017453"),
        ("torque_cmd_nm", "torque_cmd_mnm", "torque_cmd_nm: required column is missing; "),
    ] {
        fs::write(at("run.csv"), text.replacen(from, to, 1)).unwrap();
        refused(folder.path(), &compare, message);
    }
    fs::write(at("run.csv"), text.replacen("t_s,", "a,", 1).replacen("position_rad", "b", 1)).unwrap();
    refused(folder.path(), &compare, "t_s, position_rad: required columns are missing");
}
