//! No output loses a file, and what cannot be written is known before anything is computed.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use recording::output::{Files, mark};

/// What `check` says of these inputs and outputs, without the folder.
fn check(folder: &Path, inputs: &[&str], outputs: &[&str], force: bool) -> Result<(), String> {
    let mut files = Files::new(force);
    files.reads_all(&inputs.iter().map(|name| folder.join(name)).collect::<Vec<PathBuf>>());
    for name in outputs {
        files.writes(&folder.join(name));
    }
    files.check().map(drop).map_err(|error| {
        assert_eq!(error.exit_code(), 2);
        error.to_string().replace(&format!("{}/", folder.display()), "")
    })
}

fn refused(folder: &Path, inputs: &[&str], outputs: &[&str], message: &str) {
    let said = check(folder, inputs, outputs, false).expect_err(message);
    assert!(said.contains(message), "{outputs:?}: {said}");
}

#[cfg(unix)]
#[test]
fn an_output_that_is_an_input_is_refused_by_whatever_name() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("sub")).unwrap();
    fs::write(at("victim.csv"), "t_s,x\n0,1\n").unwrap();
    std::os::unix::fs::symlink("victim.csv", at("link.csv")).unwrap();
    std::os::unix::fs::symlink(at("sub"), at("way")).unwrap();
    fs::hard_link(at("victim.csv"), at("hard.csv")).unwrap();
    for name in ["victim.csv", "./victim.csv", "sub/../victim.csv", "way/../victim.csv", "link.csv", "hard.csv"] {
        refused(folder.path(), &["victim.csv"], &[name], "it is the input `victim.csv`; choose another name");
        let forced = check(folder.path(), &["victim.csv"], &[name], true).unwrap_err();
        assert!(forced.contains("it is the input"), "--force never loses an input: {forced}");
    }
    // Nor through a link on the side of the input, nor one that leads to what is not there yet.
    refused(folder.path(), &["link.csv"], &["victim.csv"], "it is the input `link.csv`");
    refused(folder.path(), &["sub/new.csv"], &["way/new.csv"], "it is the input `sub/new.csv`");
    assert_eq!(fs::read_to_string(at("victim.csv")).unwrap(), "t_s,x\n0,1\n");
}

#[cfg(unix)]
#[test]
fn two_outputs_are_two_files() {
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("a.json", folder.path().join("link.html")).unwrap();
    std::os::unix::fs::symlink("circle", folder.path().join("circle")).unwrap();
    refused(folder.path(), &[], &["a.json", "./a.json"], "./a.json: cannot write: it is the output `a.json` too");
    refused(folder.path(), &[], &["a.json", "link.html"], "link.html: cannot write: it is the output `a.json` too");
    refused(folder.path(), &[], &["new/b.svg", "new/../new/b.svg"], "it is the output `new/b.svg` too");
    refused(folder.path(), &[], &["circle"], "its links lead in a circle");
    assert_eq!(check(Path::new("/dev"), &["null"], &["null", "null"], false), Ok(()), "a device loses nothing");
}

#[test]
fn a_file_that_another_wrote_is_replaced_only_by_force() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("thesis.html"), "<html>my own").unwrap();
    fs::write(at("empty"), "").unwrap();
    fs::write(at("ours.svg"), format!("<svg>\n<!-- {} -->\n</svg>", mark::WORDS)).unwrap();
    fs::create_dir(at("sub")).unwrap();
    refused(folder.path(), &[], &["thesis.html"], "it is there and servo-lab did not write it");
    assert_eq!(check(folder.path(), &[], &["thesis.html"], true), Ok(()));
    assert_eq!(check(folder.path(), &[], &["empty", "ours.svg", "new.json"], false), Ok(()));
    refused(folder.path(), &[], &["sub"], "sub: cannot write: it is a folder");
    let mut rights = fs::metadata(at("ours.svg")).unwrap().permissions();
    rights.set_readonly(true);
    fs::set_permissions(at("ours.svg"), rights).unwrap();
    refused(folder.path(), &[], &["ours.svg"], "it is write-protected");
}

#[test]
fn what_cannot_be_written_is_known_first_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "x").unwrap();
    refused(folder.path(), &[], &["file/below.json"], "file/below.json: cannot write: ");
    refused(folder.path(), &[], &["file/below.json"], "file is no folder");
    assert_eq!(check(folder.path(), &[], &["a/b/c.json", "a/d.json"], false), Ok(()));
    let names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["file"], "neither folders nor temporary files stay");
}

/// Rights do not stop root, who runs tests in containers; the kernel's own folder takes files from nobody.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_takes_no_file_is_known_before_the_computing() {
    refused(Path::new("/proc"), &[], &["answer.json"], "answer.json: cannot write: ");
    refused(Path::new("/proc"), &[], &["new/answer.json"], "new/answer.json: cannot write: ");
}

#[test]
fn all_outputs_appear_or_none() {
    let folder = tempfile::tempdir().unwrap();
    let (one, two) = (folder.path().join("new/one.md"), folder.path().join("two.md"));
    let mut files = Files::new(false);
    let outputs = [files.writes(&one), files.writes(&two)];
    let mut ready = files.check().unwrap();
    ready.write(outputs[0], |to| to.write_all(b"one")).unwrap();
    let full = ready.write(outputs[1], |to| {
        to.write_all(b"half")?;
        Err(std::io::Error::from(std::io::ErrorKind::StorageFull))
    });
    assert_eq!(full.unwrap_err().to_string(), format!("{}: cannot write: no storage space", two.display()));
    drop(ready);
    assert!(!one.exists() && !two.exists());
    let mut files = Files::new(false);
    let output = files.writes(&one);
    let mut ready = files.check().unwrap();
    ready.write(output, |to| to.write_all(b"one")).unwrap();
    assert!(!one.exists());
    ready.finish().unwrap();
    assert_eq!(fs::read_to_string(&one).unwrap(), "one");
}
