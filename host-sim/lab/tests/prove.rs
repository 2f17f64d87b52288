//! `servo-lab prove` as a user runs it: sealed, resumable, and repeatable by seed.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::Path;

use assert_cmd::Command;

fn prove(out: &Path, flags: &[&str]) -> String {
    let mut command = Command::cargo_bin("servo-lab").unwrap();
    let output = command.arg("prove").args(flags).arg("--out").arg(out).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_case_is_sealed_judged_kept_and_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let first = prove(folder.path(), &["--case", "0"]);
    assert!(first.contains("1 cases, sealed: SHA-256 "), "{first}");
    assert!(first.contains("clean"), "{first}");
    let text = std::fs::read(folder.path().join("sealed/0.json")).unwrap();
    let sums = std::fs::read_to_string(folder.path().join("sealed/SHA256SUMS")).unwrap();
    assert_eq!(sums, format!("{}  0.json\n", conceal::seal::hash(&text)));
    assert!(folder.path().join("cases/0/machine.toml").exists() && folder.path().join("cases/0/a.csv").exists());
    // The outcome is there: the second run reads it, and the merge counts it.
    std::fs::remove_dir_all(folder.path().join("cases")).unwrap();
    assert_eq!(prove(folder.path(), &["--case", "0"]), first);
    assert!(!folder.path().join("cases").exists());
    let merged = prove(folder.path(), &["--merge", folder.path().to_str().unwrap()]);
    assert!(first.ends_with(&merged), "{merged}");
}

#[test]
fn a_shard_that_is_none_is_refused() {
    let mut command = Command::cargo_bin("servo-lab").unwrap();
    let output = command.args(["prove", "--shard", "3/2"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}
