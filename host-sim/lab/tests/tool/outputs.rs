//! Files that the commands write: none is lost, what cannot be written is known first, and what made it is told.

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

const MACHINE: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\n\
                       resolution = 1.2783173e-5\n[plant]\ninertia = 0.075\ncoulomb = 0.763\ntorque_limit = 30\n\
                       torque_delay_s = 0.005\n[plant.er]\na = 0.0704\nb = 0.470\ndead_time_s = 0.002\nlag_s = 0.003\n";

fn lab(folder: &Path, line: &str) -> Output {
    let mut command = Command::cargo_bin("servo-lab").unwrap();
    command.current_dir(folder).env("SOURCE_DATE_EPOCH", "1700000000").args(line.split_whitespace()).output().unwrap()
}

fn done(folder: &Path, line: &str) -> String {
    let output = lab(folder, line);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Exit code 2 and one line that holds `message` and no name of a temporary file.
fn refused(folder: &Path, line: &str, message: &str) {
    let output = lab(folder, line);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}: {errors}");
    assert!(errors.lines().count() == 1 && errors.contains(message), "{line}: {errors}");
    assert!(!errors.contains(".servo-lab-"), "{errors}");
}

/// Every file of the folder with its content, by name.
fn content(folder: &Path) -> Vec<(std::ffi::OsString, Vec<u8>)> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let mut files: Vec<_> =
        entries.map(|entry| (entry.file_name(), fs::read(entry.path()).unwrap_or_default())).collect();
    files.sort();
    files
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("m.toml"), MACHINE).unwrap();
    fs::write(at("reference.csv"), "t_s,reference_rad\n0,0\n0.1,0.3\n").unwrap();
    fs::write(at("image.elf"), "no image").unwrap();
    fs::write(at("rtt.bin"), "no log").unwrap();
    fs::write(at("rtt.csv"), "no log").unwrap();
    fs::write(at("tuned.toml"), MACHINE).unwrap();
    fs::write(at("notes.txt"), "mine").unwrap();
    done(folder.path(), "simulate --duration-s 0.3 --out run.csv");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("run.csv", at("link.csv")).unwrap();
        fs::hard_link(at("m.toml"), at("hard.toml")).unwrap();
    }
    folder
}

#[test]
fn no_command_writes_onto_what_it_reads() {
    let folder = folder();
    let before = content(folder.path());
    let lines = [
        ("diagnose --machine m.toml run.csv --html run.csv", "run.csv"),
        ("diagnose --machine m.toml run.csv --json ./run.csv --force", "run.csv"),
        ("diagnose --machine m.toml run.csv --experiment link.csv", "run.csv"),
        ("diagnose --machine m.toml run.csv --write-model hard.toml --force", "m.toml"),
        ("diagnose --machine m.toml run.csv --holdout link.csv --json link.csv", "run.csv"),
        ("simulate --machine m.toml --reference reference.csv --out reference.csv", "reference.csv"),
        ("decode --elf image.elf rtt.bin --out image.elf", "image.elf"),
        ("stability --machine m.toml --json m.toml --force", "m.toml"),
        ("stability --machine m.toml --plot hard.toml", "m.toml"),
        ("stability --machine m.toml --html m.toml --force", "m.toml"),
        ("compare --machine m.toml run.csv --html link.csv --force", "run.csv"),
        ("tune --machine m.toml --html hard.toml --force", "m.toml"),
        ("paper --measured run.csv --html run.csv", "run.csv"),
        ("prove --case 0 --program image.elf --html image.elf", "image.elf"),
        ("prove --case 0 --program image.elf --json image.elf", "image.elf"),
        ("simulate --reference reference.csv --plot ./reference.csv", "reference.csv"),
        ("convert run.csv --out link.csv --force", "run.csv"),
        ("init run.csv --out run.csv", "run.csv"),
        ("record --elf image.elf rtt.csv --out rtt.csv", "rtt.csv"),
        ("tune --machine tuned.toml --out .", "tuned.toml"),
    ];
    for (line, input) in lines {
        refused(folder.path(), line, &format!("cannot write: it is the input `{input}`; choose another name"));
    }
    fs::create_dir(folder.path().join("plots")).unwrap();
    fs::copy(folder.path().join("run.csv"), folder.path().join("plots/compare-run.svg")).unwrap();
    fs::rename(folder.path().join("plots/compare-run.svg"), folder.path().join("plots/compare-run.csv")).unwrap();
    for (line, message) in [
        ("diagnose --machine m.toml run.csv --html a.out --json ./a.out", "it is the output `./a.out` too"),
        ("compare --machine m.toml run.csv link.csv ./run.csv", "it is the output `./compare-run.svg` too"),
    ] {
        refused(folder.path(), line, message);
    }
    fs::remove_dir_all(folder.path().join("plots")).unwrap();
    assert_eq!(content(folder.path()), before);
}

#[test]
fn a_file_of_another_hand_is_replaced_only_by_force() {
    let folder = folder();
    for (line, own) in [
        ("simulate --duration-s 0.1 --out notes.csv", "notes.csv"),
        ("simulate --duration-s 0.1 --out notes.parquet", "notes.parquet"),
        ("compare --machine m.toml run.csv --plots pictures/new", "pictures/new/compare-run.svg"),
        ("stability --machine m.toml --json notes.json", "notes.json"),
        ("stability --machine m.toml --plot notes.svg", "notes.svg"),
        ("stability --machine m.toml --html notes.html", "notes.html"),
        ("compare --machine m.toml run.csv --plots pictures --html compared.html", "compared.html"),
    ] {
        let file = folder.path().join(own);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(&file, "mine").unwrap();
        refused(folder.path(), line, "it is there and servo-lab did not write it");
        assert_eq!(fs::read_to_string(&file).unwrap(), "mine", "{line}");
        done(folder.path(), &format!("{line} --force"));
        assert_ne!(fs::read(&file).unwrap(), b"mine", "{line}");
        done(folder.path(), line);
    }
}

#[test]
fn what_cannot_be_written_is_known_first_by_the_users_name() {
    let folder = folder();
    let before = content(folder.path());
    for line in [
        "diagnose --machine m.toml run.csv --json notes.txt/answer.json",
        "diagnose --machine m.toml run.csv --html notes.txt/answer.html",
        "compare --machine m.toml run.csv --plots notes.txt/plots",
        "tune --out notes.txt/tune",
        "paper --out notes.txt/paper",
        "guide --out notes.txt/guide",
        "demo --out notes.txt/demo",
        "man --out notes.txt/man",
        "prove --case 0 --out notes.txt/proof",
        "prove --case 0 --write-only notes.txt/cases",
        "prove --case 0 --html notes.txt/page.html",
        "convert run.csv --out notes.txt/run.csv",
        "init run.csv --out notes.txt/m.toml",
        "decode --elf image.elf rtt.bin --out notes.txt/run.csv",
        "record --elf image.elf rtt.bin --out notes.txt/run.csv",
        "simulate --out notes.txt/run.csv",
        "stability --plot notes.txt/region.svg",
        "stability --html notes.txt/page.html",
        "compare --machine m.toml run.csv --html notes.txt/page.html",
        "tune --html notes.txt/page.html",
        "paper --html notes.txt/page.html",
    ] {
        refused(folder.path(), line, "notes.txt is no folder");
    }
    assert_eq!(content(folder.path()), before, "nothing is left");
    done(folder.path(), "simulate --duration-s 0.1 --out new/folder/run.csv");
    assert!(folder.path().join("new/folder/run.csv").is_file(), "folders are made");
}

/// Commands that compute for long, or that nothing was recorded for: refused before they begin.
#[test]
fn every_other_command_asks_too_before_it_replaces_a_file() {
    let folder = folder();
    for (line, own) in [
        ("guide --out guide", "guide/guide.md"),
        ("paper --out paper", "paper/claims.md"),
        ("paper --beyond --out paper", "paper/beyond.md"),
        ("tune --out tuned", "tuned/tune.svg"),
        ("demo --out demo", "demo/machine.toml"),
        ("man --out man", "man/servo-lab-tune.1"),
        ("init run.csv --out mine.toml", "mine.toml"),
        ("convert run.csv --out mine.csv", "mine.csv"),
        ("decode --elf image.elf rtt.bin --out mine.csv", "mine.csv"),
        ("record --elf image.elf rtt.bin --out mine.csv", "mine.csv"),
        ("diagnose --machine m.toml run.csv --write-model mine.toml", "mine.toml"),
        ("prove --case 0 --json mine.json", "mine.json"),
        ("prove --case 0 --html mine.html", "mine.html"),
        ("paper --beyond --html mine.html", "mine.html"),
        ("tune --html mine.html", "mine.html"),
        ("prove --case 0 --out proof", "proof/about.md"),
        ("prove --case 0 --write-only proof", "proof/about.md"),
    ] {
        let file = folder.path().join(own);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(&file, "mine").unwrap();
        let before = content(file.parent().unwrap());
        refused(folder.path(), line, "it is there and servo-lab did not write it");
        assert_eq!(content(file.parent().unwrap()), before, "{line}");
    }
}

#[cfg(unix)]
#[test]
fn a_folder_of_another_hand_is_filled_only_by_force() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let answer = r#"{"verdict": "none", "effects": []}"#;
    let tool = |file: &str| {
        fs::create_dir_all(at(file).parent().unwrap()).unwrap();
        fs::write(at(file), format!("#!/bin/sh\ncat > \"$5\" <<'END'\n{answer}\nEND\n")).unwrap();
        fs::set_permissions(at(file), fs::Permissions::from_mode(0o755)).unwrap();
    };
    tool("tool");
    fs::create_dir_all(at("mine/cases/0")).unwrap();
    fs::write(at("mine/cases/0/thesis.csv"), "mine").unwrap();
    let run = "prove --case 0 --no-rivals --program tool --out mine";
    refused(folder.path(), run, "mine/cases: cannot write: it holds files and servo-lab did not fill it");
    assert!(!at("mine/sealed").exists());
    done(folder.path(), &format!("{run} --force"));
    done(folder.path(), run);
    let again = "prove --count 1 --no-rivals --program tool --out mine";
    fs::remove_dir_all(at("mine/outcomes")).unwrap();
    done(folder.path(), again);
    assert_eq!(fs::read_to_string(at("mine/cases/0/thesis.csv")).unwrap(), "mine", "a folder that was there stays");
    tool("own/cases/0/tool");
    refused(
        folder.path(),
        "prove --case 0 --program own/cases/0/tool --out own --force",
        "own/cases: cannot write: it will be filled, and `own/cases/0/tool` is in it",
    );
    fs::write(at("mine/clean"), "mine").unwrap();
    refused(folder.path(), "prove --case 0 --write-only mine", "is no folder");
    fs::create_dir_all(at("other/clean/0")).unwrap();
    fs::write(at("other/clean/0/a.csv"), "mine").unwrap();
    refused(folder.path(), "prove --case 0 --write-only other", "other/clean/0: cannot write: it holds files");
    refused(
        folder.path(),
        "prove --merge mine --json mine/outcomes/0.json --force",
        "it is the input `mine/outcomes/0.json`",
    );
}

/// A limit on the size of files stands for a disk that fills up while the file is written.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_nothing_half_written() {
    let folder = folder();
    let before = content(folder.path());
    let program = assert_cmd::cargo::cargo_bin("servo-lab");
    let script = format!("trap '' XFSZ; ulimit -f 8; exec {} simulate --duration-s 2 --out run.csv", program.display());
    let output = std::process::Command::new("sh").current_dir(folder.path()).args(["-c", &script]).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.starts_with("error: run.csv: cannot write: ") && errors.lines().count() == 1, "{errors}");
    assert_eq!(content(folder.path()), before);
}

#[test]
fn json_tells_what_made_it_and_is_the_same_twice() {
    let folder = folder();
    done(folder.path(), "stability --machine m.toml --json one.json");
    let one = fs::read_to_string(folder.path().join("one.json")).unwrap();
    done(folder.path(), "stability --machine m.toml --json one.json");
    assert_eq!(one, fs::read_to_string(folder.path().join("one.json")).unwrap());
    let json: serde_json::Value = serde_json::from_str(&one).unwrap();
    let made = &json["provenance"];
    assert_eq!(made["command"], "servo-lab stability --machine m.toml --json one.json");
    assert_eq!(made["date"], "2023-11-14T22:13:20Z");
    assert_eq!(made["inputs"][0]["file"], "m.toml");
    assert_eq!(made["inputs"][0]["sha256"].as_str().unwrap().len(), 64);
    assert!(made["written_by"].as_str().unwrap().starts_with("Written by servo-lab 0"), "{made}");
    assert!(made["commit"].as_str().is_some_and(|commit| !commit.is_empty()) && json["plant"].is_object(), "{json}");
    let printed = done(folder.path(), "stability --machine m.toml --json -");
    assert!(serde_json::from_str::<serde_json::Value>(&printed).unwrap()["provenance"].is_object());
}

#[test]
fn exit_codes_are_in_the_help() {
    let folder = tempfile::tempdir().unwrap();
    for line in ["--help", "diagnose --help", "link --help"] {
        let help = done(folder.path(), line);
        assert!(help.contains("Exit codes:\n  0  done") && help.contains("\n  4  link"), "{help}");
    }
    let help = done(folder.path(), "diagnose --help");
    assert!(help.contains("--fail-on <VERDICT>") && help.contains("ambiguous"), "{help}");
    assert_eq!(lab(folder.path(), "diagnose --machine m --fail-on perhaps r.csv").status.code(), Some(2));
}

#[test]
fn data_that_nothing_can_be_computed_from_is_refused_before_the_search() {
    let folder = folder();
    done(folder.path(), "simulate step --amplitude-deg 0 --duration-s 2 --out still.csv");
    refused(folder.path(), "diagnose --machine m.toml still.csv", "still.csv: position_rad: the axis never moves");
    refused(
        folder.path(),
        "diagnose --machine m.toml run.csv",
        "run.csv: 0.299 s is too short, at least 0.8 s is needed",
    );
    let run = fs::read_to_string(folder.path().join("run.csv")).unwrap();
    let slow = run.lines().enumerate().map(|(row, line)| match line.split_once(',') {
        Some((_, rest)) if row > 0 => format!("{row},{rest}\n"),
        _ => format!("{line}\n"),
    });
    fs::write(folder.path().join("slow.csv"), slow.collect::<String>()).unwrap();
    refused(
        folder.path(),
        "compare --machine m.toml slow.csv",
        "t_s: rows are 1 s apart, at most 0.05 s can be worked on",
    );
}

#[test]
#[cfg_attr(debug_assertions, ignore = "a minute without optimisation; the tests in release run it")]
fn a_verdict_that_is_asked_about_ends_with_1_and_the_page_tells_what_made_it() {
    let folder = folder();
    done(folder.path(), "simulate steps --duration-s 3 --machine m.toml --torque-noise-nm 0.02 --out steps.csv");
    let line =
        "diagnose --machine m.toml steps.csv --only viscous_friction --json a.json --html a.html --write-model b.toml";
    done(folder.path(), line);
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("a.json")).unwrap()).unwrap();
    let verdict = json["verdict"].as_str().unwrap();
    let others: Vec<&str> = ["none", "named", "partial", "ambiguous", "unknown", "controller"]
        .into_iter()
        .filter(|other| *other != verdict)
        .collect();
    assert_eq!(lab(folder.path(), &format!("{line} --fail-on {verdict}")).status.code(), Some(1));
    assert_eq!(lab(folder.path(), &format!("{line} --fail-on {}", others.join(","))).status.code(), Some(0));
    let page = fs::read_to_string(folder.path().join("a.html")).unwrap();
    let sha256 = json["provenance"]["inputs"][1]["sha256"].as_str().unwrap();
    assert!(page.contains("How to reproduce this page") && page.contains(sha256));
    assert!(fs::read_to_string(folder.path().join("b.toml")).unwrap().starts_with("# Written by servo-lab"));
    assert_eq!((json["schema"].as_u64(), json["provenance"]["seed"].as_u64()), (Some(2), Some(1)));
}

/// The same command twice, and with another number of threads: one answer, to the byte.
#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_diagnosis_is_the_same_twice_whatever_the_threads() {
    let folder = folder();
    done(folder.path(), "simulate steps --duration-s 2 --machine m.toml --torque-noise-nm 0.02 --out steps.csv");
    let written = |jobs: usize| {
        let only = "--only viscous_friction,coulomb_friction";
        let line =
            format!("diagnose --machine m.toml steps.csv {only} --jobs {jobs} --json a.json --html a.html --force");
        done(folder.path(), &line);
        ["a.json", "a.html"].map(|name| fs::read_to_string(folder.path().join(name)).unwrap())
    };
    let one = written(1);
    assert_eq!(one, written(1));
    // What is asked for is told, and is all that differs.
    let two = written(2).map(|text| text.replace("--jobs 2", "--jobs 1"));
    assert!(one == two, "another number of threads is another answer");
}
