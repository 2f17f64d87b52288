//! The book in `docs`: every command of its first page runs, every page is listed, every link leads somewhere.
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

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn every_command_of_ten_minutes_with_your_own_log_runs() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("log.csv"), files::csv(&machine::pushed_pendulum(20.0))).unwrap();
    let program = cargo_bin("servo-lab");
    let mut folders = vec![program.parent().unwrap().to_path_buf()];
    folders.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap()));
    let path = std::env::join_paths(folders).unwrap();
    let blocks = commands(&page("your-own-log.md"));
    assert!(blocks.len() >= 5, "{blocks:?}");
    for block in blocks {
        let output =
            Command::new("sh").args(["-e", "-c", &block]).current_dir(folder.path()).env("PATH", &path).output();
        let output = output.unwrap();
        println!("{block}{}", String::from_utf8_lossy(&output.stdout));
        assert!(output.status.success(), "{block}: {}", String::from_utf8_lossy(&output.stderr));
    }
    for made in ["machine.toml", "answer.html", "improved.toml", "log.mcap", "log.parquet"] {
        assert!(folder.path().join(made).is_file(), "{made}");
    }
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
