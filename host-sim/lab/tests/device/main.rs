//! `decode`, `record` and `link` against a drive: the image's own server, law and drivers on the simulated plant, its log
//! written as the image writes it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod decode;
mod drive;
mod far;
mod identify;
mod link;
mod log;
mod record;

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

/// Runs `servo-lab` in a folder.
fn lab(folder: &Path, line: &str) -> Output {
    Command::cargo_bin("servo-lab").unwrap().current_dir(folder).args(line.split_whitespace()).output().unwrap()
}

/// What a command that succeeds prints.
fn printed(folder: &Path, line: &str) -> String {
    let output = lab(folder, line);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The last line of message of a command that ends with `code`.
fn fails(folder: &Path, line: &str, code: i32) -> String {
    let output = lab(folder, line);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{line}: {errors}");
    assert!(output.stdout.is_empty(), "{line}");
    errors.lines().last().unwrap_or_default().to_owned()
}
