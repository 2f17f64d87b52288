//! Links of the pages: in the repository, and in the book as it is built.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use scraper::{Html, Selector};

use crate::{docs, page, root, text};

/// Targets of the links of a page that are files.
pub fn targets(text: &str) -> Vec<String> {
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let files = targets.filter(|target| !target.contains("://") && !target.starts_with('#'));
    files.map(|target| target.split('#').next().unwrap().to_owned()).collect()
}

#[test]
fn every_page_is_listed_and_every_link_leads_somewhere() {
    let listed = targets(&page("SUMMARY.md"));
    // Ten minutes, reading, formats, method, field guide, drive, effect, porting, scores, and the JSON.
    assert!(listed.len() >= 10, "{listed:?}");
    for entry in fs::read_dir(docs()).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        if !name.ends_with(".md") {
            continue;
        }
        assert!(name == "SUMMARY.md" || listed.contains(&name), "docs/{name} is not in SUMMARY.md");
        let links = targets(&page(&name));
        for link in &links {
            assert!(docs().join(link).exists(), "docs/{name} leads to {link}, which is not there");
        }
        // The book has the pages alone.
        assert!(!links.iter().any(|link| link.starts_with("..")), "docs/{name}: a link leaves the folder");
    }
    for name in ["README.md", "CONTRIBUTING.md", "examples/README.md"] {
        for link in targets(&text(name)) {
            let folder = Path::new(name).parent().unwrap();
            assert!(root().join(folder).join(&link).exists(), "{name} leads to {link}, which is not there");
        }
    }
}

/// Every link and picture of a page of the built book that is a file of it: the file, and the place within it.
fn within(html: &Html) -> Vec<(String, String)> {
    let elements = [("main a[href]", "href"), ("nav a[href]", "href"), ("main img[src]", "src")];
    let found = elements.iter().flat_map(|(selector, attribute)| {
        let selector = Selector::parse(selector).unwrap();
        let values = html.select(&selector).map(|element| element.value().attr(attribute).unwrap().to_owned());
        values.collect::<Vec<_>>()
    });
    let files = found.filter(|target| !target.contains("://"));
    files
        .map(|target| target.split_once('#').map_or((target.clone(), String::new()), |(a, b)| (a.into(), b.into())))
        .collect()
}

/// Links of a built page that lead nowhere.
fn dead(file: &Path) -> Vec<String> {
    let html = Html::parse_document(&fs::read_to_string(file).unwrap());
    let leads = |(target, place): &(String, String)| {
        let target = if target.is_empty() { file.to_path_buf() } else { file.parent().unwrap().join(target) };
        let Ok(found) = fs::read_to_string(&target) else { return false };
        place.is_empty() || found.contains(&format!("id=\"{place}\""))
    };
    let targets = within(&html);
    assert!(!targets.is_empty(), "{}", file.display());
    targets.into_iter().filter(|target| !leads(target)).map(|(target, place)| format!("{target}#{place}")).collect()
}

/// Builds the book into a folder; false, with the reason printed, where mdBook is not there. In CI it must be.
fn built(folder: &Path) -> bool {
    if Command::new("mdbook").arg("--version").output().is_err() {
        assert!(std::env::var_os("CI").is_none(), "mdbook must be there in CI; .ci/run installs it");
        println!("not built: mdbook is not on the path (cargo install mdbook)");
        return false;
    }
    let output = Command::new("mdbook").arg("build").arg(docs()).arg("--dest-dir").arg(folder).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !said.contains("WARN") && !said.contains("ERROR"), "{said}");
    true
}

#[test]
fn the_book_builds_and_no_link_in_it_is_dead() {
    let folder = tempfile::tempdir().unwrap();
    if !built(folder.path()) {
        return;
    }
    for name in targets(&page("SUMMARY.md")) {
        let file: PathBuf = folder.path().join(&name).with_extension("html");
        let dead = dead(&file);
        assert!(dead.is_empty(), "{name} as built: {dead:?}");
    }
}
