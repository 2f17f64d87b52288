//! The book in `docs`: every command in it runs, every page is listed, every link leads somewhere, and it builds.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "own_logs/files.rs"]
// Other tests write logs in the other formats.
#[allow(dead_code)]
mod files;
#[path = "own_logs/plant.rs"]
mod machine;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use assert_cmd::cargo::cargo_bin;
use lab::read::{Column, Machine};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs")
}

fn page(name: &str) -> String {
    fs::read_to_string(docs().join(name)).unwrap_or_else(|error| panic!("docs/{name}: {error}"))
}

/// The blocks of commands of a page.
fn commands(page: &str) -> Vec<String> {
    let blocks = page.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap().to_owned());
    blocks.collect()
}

/// The page of a new user, whose commands belong together.
const OWN_LOG: &str = "your-own-log.md";
/// The page whose commands need a drive: that they exist, with all their flags, is all that can be looked at.
const DRIVE: &str = "drive.md";

/// Runs blocks of commands in a folder, as they stand in the book.
fn run(folder: &Path, blocks: Vec<String>) {
    let program = cargo_bin("servo-lab");
    let mut folders = vec![program.parent().unwrap().to_path_buf()];
    folders.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap()));
    let path = std::env::join_paths(folders).unwrap();
    for block in blocks {
        let output = Command::new("sh").args(["-e", "-c", &block]).current_dir(folder).env("PATH", &path).output();
        let output = output.unwrap();
        println!("{block}{}", String::from_utf8_lossy(&output.stdout));
        assert!(output.status.success(), "{block}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn every_command_of_ten_minutes_with_your_own_log_runs() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("log.csv"), files::csv(&machine::pushed_pendulum(20.0))).unwrap();
    let blocks = commands(&page(OWN_LOG));
    assert!(blocks.len() >= 5, "{blocks:?}");
    run(folder.path(), blocks);
    for made in ["machine.toml", "answer.html", "improved.toml", "log.mcap", "log.parquet"] {
        assert!(folder.path().join(made).is_file(), "{made}");
    }
}

/// A servo with a law, for the pages that take a machine for granted.
const MACHINE: &str = include_str!("../src/cli/demo/machine.toml");

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn every_command_of_the_other_pages_runs() {
    let pages: Vec<String> =
        links(&page("SUMMARY.md")).into_iter().filter(|name| name != OWN_LOG && name != DRIVE).collect();
    let mut count = 0;
    for name in pages {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("machine.toml"), MACHINE).unwrap();
        let blocks = commands(&page(&name));
        count += blocks.len();
        run(folder.path(), blocks);
    }
    assert!(count >= 4, "{count} blocks");
}

/// The blocks of a machine file of a page.
fn blocks_of_toml(name: &str) -> Vec<String> {
    let page = page(name);
    page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap().to_owned()).collect()
}

/// A machine file that has nothing that a page shows.
const BARE: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\nresolution = 1e-5\n\
                    [plant]\ninertia = 0.075\n";

fn read_machine(text: &str) -> Machine {
    Machine::from_bytes(Path::new("machine.toml"), text.as_bytes()).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn the_machine_files_that_the_book_shows_are_read() {
    let formats = blocks_of_toml("formats.md");
    let [columns, wrapping] = &formats[..] else { panic!("{formats:?}") };
    let machine = read_machine(&format!("{BARE}{columns}"));
    let torque = machine.columns.columns().iter().find(|mapped| mapped.column == Column::EffortCmd).unwrap();
    assert_eq!((torque.name.as_str(), torque.unit.as_str(), torque.scale), ("Motor Current [A]", "A", 0.12));
    let position = columns.lines().find(|line| line.starts_with("position")).unwrap();
    let machine = read_machine(&format!("{BARE}{}", columns.replace(position, wrapping)));
    assert!(machine.columns.columns().iter().any(|mapped| mapped.wrap == Some(25.0)));
    let fluid = blocks_of_toml("fluid.md");
    assert!(!fluid.is_empty());
    for block in fluid {
        let er = read_machine(&format!("{BARE}{block}")).plant.er.unwrap();
        assert_eq!(er.fluid.unwrap().electrode.unwrap().gap_m, 5e-4);
    }
}

/// With `--help` behind it a command tells what it is, and refuses words before it that it does not know.
#[test]
fn every_command_for_a_drive_exists_with_its_flags() {
    let blocks = commands(&page(DRIVE));
    let lines = blocks.iter().flat_map(|block| block.lines()).map(|line| line.split(" #").next().unwrap().trim());
    let lines: Vec<&str> = lines.filter(|line| !line.is_empty()).collect();
    assert!(lines.len() >= 4, "{lines:?}");
    for line in lines {
        let words = line.strip_prefix("servo-lab ").unwrap_or_else(|| panic!("`{line}` is no command of servo-lab"));
        let output =
            Command::new(cargo_bin("servo-lab")).args(words.split_whitespace()).arg("--help").output().unwrap();
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn the_book_builds() {
    if Command::new("mdbook").arg("--version").output().is_err() {
        println!("not built: mdbook is not on the path (cargo install mdbook)");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new("mdbook").arg("build").arg(docs()).arg("--dest-dir").arg(folder.path()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !said.contains("WARN") && !said.contains("ERROR"), "{said}");
    assert!(folder.path().join("drive.html").is_file());
}

/// Targets of the links of a page that are files.
fn links(text: &str) -> Vec<String> {
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let files = targets.filter(|target| !target.contains("://") && !target.starts_with('#'));
    files.map(|target| target.split('#').next().unwrap().to_owned()).collect()
}

#[test]
fn every_page_is_listed_and_every_link_leads_somewhere() {
    let listed = links(&page("SUMMARY.md"));
    // Ten minutes, reading, formats, method, field guide, drive, effect, porting, scores, and the JSON.
    assert!(listed.len() >= 10, "{listed:?}");
    for entry in fs::read_dir(docs()).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        if !name.ends_with(".md") {
            continue;
        }
        assert!(name == "SUMMARY.md" || listed.contains(&name), "docs/{name} is not in SUMMARY.md");
        for link in links(&page(&name)) {
            assert!(docs().join(&link).exists(), "docs/{name} leads to {link}, which is not there");
        }
    }
}

#[test]
fn the_glossary_has_every_verdict() {
    let glossary = page("reading-the-answer.md");
    for verdict in ["none", "named", "partial", "ambiguous", "unknown", "controller"] {
        assert!(glossary.contains(&format!("| `{verdict}` |")), "{verdict}");
    }
}
