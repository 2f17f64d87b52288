//! Which sources this is built from, for the provenance of what the program writes.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // The log of HEAD grows with each commit and each switch of branch; the sources tell whether they differ from it.
    for place in ["logs/HEAD", "HEAD"] {
        if let Some(path) = git(&["rev-parse", "--path-format=absolute", "--git-path", place])
            && std::path::Path::new(&path).exists()
        {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    for sources in ["src", "../../src"] {
        println!("cargo::rerun-if-changed={sources}");
    }
    for other in ["analysis", "conceal", "plant", "progress", "recording", "wire"] {
        println!("cargo::rerun-if-changed=../{other}/src");
    }
    println!("cargo::rustc-env=SERVO_LAB_COMMIT={}", commit());
}

/// The commit, and whether the sources differ from it.
fn commit() -> String {
    let Some(commit) = git(&["rev-parse", "HEAD"]) else { return "unknown".to_owned() };
    let changed = git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|lines| !lines.is_empty());
    if changed { format!("{commit}, with changes") } else { commit }
}

/// What git says; none without git or a repository.
fn git(words: &[&str]) -> Option<String> {
    let output = Command::new("git").args(words).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
