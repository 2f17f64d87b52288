//! README, `examples` and the book in `docs`: every command in them runs, every link leads somewhere, and what they say of the
//! tool is so.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "book/contents.rs"]
mod contents;
#[path = "book/examples.rs"]
mod examples;
#[path = "tool/own_logs/files.rs"]
mod files;
#[path = "book/links.rs"]
mod links;
#[path = "tool/own_logs/plant.rs"]
mod machine;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use assert_cmd::cargo::cargo_bin;
use lab::read::{Column, Machine};

/// The folder of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn docs() -> PathBuf {
    root().join("docs")
}

/// A text of the repository.
fn text(name: &str) -> String {
    fs::read_to_string(root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn page(name: &str) -> String {
    text(&format!("docs/{name}"))
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

/// Runs blocks of commands in a folder, as they stand in the book; programs are looked for in the folder, too.
fn run(folder: &Path, blocks: Vec<String>) {
    let program = cargo_bin("servo-lab");
    let mut folders = vec![program.parent().unwrap().to_path_buf(), folder.to_path_buf()];
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

/// The lines of "your own log", a stub in the place of the desktop's program that opens a page.
#[test]
#[cfg(unix)]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn the_readmes_lines_for_your_own_log_run() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    examples::copy(&folder.path().join("examples"));
    let open = folder.path().join("xdg-open");
    fs::write(&open, "#!/bin/sh\ntest -f \"$1\"\n").unwrap();
    fs::set_permissions(&open, fs::Permissions::from_mode(0o755)).unwrap();
    let readme = text("README.md");
    let section = readme.split("\n## ").find(|section| section.starts_with("Your own log")).unwrap();
    let blocks = commands(section);
    assert_eq!(blocks.iter().flat_map(|block| block.lines()).count(), 5, "{blocks:?}");
    run(folder.path(), blocks);
    for made in ["machine.toml", "answer.html", "improved.toml", "plots"] {
        assert!(folder.path().join(made).exists(), "{made}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn every_command_of_the_examples_runs() {
    let folder = tempfile::tempdir().unwrap();
    examples::copy(folder.path());
    let blocks = commands(&text("examples/README.md"));
    assert!(blocks.len() >= 3, "{blocks:?}");
    run(folder.path(), blocks);
}

/// A servo with a law, for the pages that take a machine for granted.
const MACHINE: &str = include_str!("../src/cli/demo/machine.toml");

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn every_command_of_the_other_pages_runs() {
    let pages: Vec<String> =
        links::targets(&page("SUMMARY.md")).into_iter().filter(|name| name != OWN_LOG && name != DRIVE).collect();
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
