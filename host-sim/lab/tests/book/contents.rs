//! What the pages say of the tool is so: its commands, its words, its parts.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use assert_cmd::cargo::cargo_bin;
use scraper::{Html, Selector};

use crate::{page, text};

#[test]
fn every_command_has_its_line() {
    let output = Command::new(cargo_bin("servo-lab")).arg("--help").output().unwrap();
    let help = String::from_utf8(output.stdout).unwrap();
    let listed = help.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let names: Vec<&str> = listed.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.len() >= 20, "{names:?}");
    let page = page("commands.md");
    for name in names {
        assert!(page.contains(&format!("`{name} ")) || page.contains(&format!("`{name}`")), "{name}");
    }
}

#[test]
fn the_glossary_has_every_term_once() {
    let glossary = page("reading-the-answer.md");
    for verdict in ["none", "named", "partial", "ambiguous", "unknown", "controller"] {
        assert_eq!(glossary.matches(&format!("| `{verdict}` |")).count(), 1, "{verdict}");
    }
    // An entry is bold; two terms may share one.
    let bold = glossary.split("**").skip(1).step_by(2);
    let entries: Vec<String> =
        bold.map(|entry| entry.trim_end_matches(['.', '?']).replace('\n', " ").to_lowercase()).collect();
    let mut terms: Vec<&str> = entries.iter().flat_map(|entry| entry.split(", ")).collect();
    terms.sort_unstable();
    let twice: Vec<&str> = terms.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
    assert!(twice.is_empty(), "more than once: {twice:?}");
    // Words that `diagnose` prints (`lab/src/report/text.rs`).
    for word in ["p", "rms", "noise", "held out", "excess explained", "left", "traces of", "next", "as good"] {
        assert!(terms.contains(&word), "{word}: {terms:?}");
    }
}

/// Which crates of this repository each crate is built on, by the manifests.
fn built_on() -> BTreeMap<String, BTreeSet<String>> {
    let folders =
        ["plant", "wire", "progress", "recording", "diagnosis", "analysis", "conceal", "lab", "python", "board"];
    let files = folders.iter().map(|folder| format!("host-sim/{folder}/Cargo.toml"));
    let manifests = files.chain(["Cargo.toml".to_owned()]).map(|file| text(&file).parse::<toml::Table>().unwrap());
    let one = |manifest: toml::Table| {
        let name = manifest["package"]["name"].as_str().unwrap().to_owned();
        let none = toml::Table::new();
        let dependencies = manifest.get("dependencies").map_or(&none, |table| table.as_table().unwrap());
        let own = dependencies.iter().filter(|(_, how)| how.get("path").is_some()).map(|(name, _)| name.clone());
        (name, own.collect())
    };
    manifests.map(one).collect()
}

/// All that a crate is built on, through others.
fn all_below(crates: &BTreeMap<String, BTreeSet<String>>, name: &str) -> BTreeSet<String> {
    let direct = &crates[name];
    direct.iter().flat_map(|below| all_below(crates, below).into_iter().chain([below.clone()])).collect()
}

/// The picture leaves out what follows: an arrow that others make up. The plant is in the firmware on a host only, so that it
/// follows from nothing.
#[test]
fn the_architecture_is_that_of_the_manifests() {
    let mut crates = built_on();
    assert!(crates.get_mut("er-servo").unwrap().remove("plant"), "dashed in the picture");
    let mut expected = BTreeSet::from([("plant".to_owned(), "er-servo".to_owned())]);
    for (name, direct) in &crates {
        let through: BTreeSet<String> = direct.iter().flat_map(|below| all_below(&crates, below)).collect();
        expected.extend(direct.difference(&through).map(|below| (below.clone(), name.clone())));
    }
    let picture = Html::parse_document(&page("architecture.svg"));
    let lines = Selector::parse("line").unwrap();
    let drawn: BTreeSet<(String, String)> = picture
        .select(&lines)
        .map(|line| ["data-from", "data-to"].map(|end| line.value().attr(end).unwrap().to_owned()).into())
        .collect();
    assert_eq!(drawn, expected);
}
