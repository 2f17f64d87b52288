//! A drive recorded while it runs.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

use crate::far::Far;
use crate::log::{Encoder, elf};
use crate::printed;

fn far() -> Option<(PathBuf, Far)> {
    let elf = elf()?;
    let far = Far::start(Some(Encoder::of(&fs::read(&elf).unwrap())));
    Some((elf, far))
}

/// Starts `servo-lab record` and waits until it listens.
fn listening(folder: &Path, elf: &Path, far: &Far) -> Child {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("servo-lab"));
    command.current_dir(folder).arg("record").arg("--elf").arg(elf);
    command.args(["--tcp", &far.log.to_string(), "--out", "rec.csv"]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let before = far.strings.readers.load(Ordering::Relaxed);
    let child = command.spawn().unwrap();
    wait_until("the reader of the log is there", || far.strings.readers.load(Ordering::Relaxed) > before);
    child
}

fn wait_until(what: &str, is_so: impl Fn() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < Duration::from_secs(30), "not within 30 s: {what}");
        thread::sleep(Duration::from_millis(5));
    }
}

/// What the child printed, and its errors.
fn ended(child: Child) -> (String, String) {
    let output = child.wait_with_output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let (printed, errors) = (text(output.stdout), text(output.stderr));
    assert!(output.status.success(), "{printed}{errors}");
    (printed, errors)
}

/// Bytes of the file that grows in the folder.
fn growing(folder: &Path) -> u64 {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().metadata().unwrap().len()).max().unwrap_or(0)
}

#[test]
fn a_run_over_tcp_is_commanded_recorded_and_replayed() {
    let Some((elf, far)) = far() else { return };
    let folder = tempfile::tempdir().unwrap();
    let child = listening(folder.path(), &elf, &far);
    for action in ["start-recording 12", "enable --autonomous", "run step --amplitude-deg 5 --duration-s 0.2"] {
        printed(folder.path(), &far.line(action));
    }
    wait_until("rows are written", || growing(folder.path()) > 0);
    assert!(!folder.path().join("rec.csv").exists(), "not before it has ended");
    for action in ["disable", "stop-recording"] {
        printed(folder.path(), &far.line(action));
    }
    let (printed_there, errors) = ended(child);
    assert!(printed_there.ends_with(" rows, the drive ended it\n"), "{printed_there}");
    assert!(errors.contains("run 12: ") && errors.contains(" 0 lost in 0 gaps, 0 damaged messages"), "{errors}");
    let replayed = printed(folder.path(), "replay rec.csv");
    assert!(replayed.contains("identical"), "{replayed}");
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_recording_with_everything_that_came() {
    let Some((elf, far)) = far() else { return };
    let folder = tempfile::tempdir().unwrap();
    let child = listening(folder.path(), &elf, &far);
    printed(folder.path(), &far.line("start-recording"));
    printed(folder.path(), &far.line("enable --autonomous"));
    wait_until("rows are written", || growing(folder.path()) > 0);
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let (printed_there, _) = ended(child);
    assert!(printed_there.ends_with(" rows, interrupted\n"), "{printed_there}");
    assert!(printed(folder.path(), "replay rec.csv").contains("identical"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "the temporary file is gone");
}

#[test]
fn a_reader_that_is_hung_up_on_keeps_what_came() {
    let Some((elf, far)) = far() else { return };
    let folder = tempfile::tempdir().unwrap();
    let child = listening(folder.path(), &elf, &far);
    printed(folder.path(), &far.line("start-recording"));
    wait_until("rows are written", || growing(folder.path()) > 0);
    far.strings.hang_up.store(true, Ordering::Relaxed);
    let (printed_there, _) = ended(child);
    assert!(printed_there.ends_with(" rows, the log ended before the recording\n"), "{printed_there}");
    assert!(fs::read_to_string(folder.path().join("rec.csv")).unwrap().lines().count() > 1);
}

#[test]
fn without_a_recording_there_is_no_file() {
    let Some((elf, far)) = far() else { return };
    let folder = tempfile::tempdir().unwrap();
    let line = format!("record --elf {} --tcp {} --for-s 0.2 --out rec.csv", elf.display(), far.log);
    assert!(crate::fails(folder.path(), &line, 4).contains("no start of a recording came"));
    let line = format!("record --elf {} --tcp {} --out nowhere/rec.csv", elf.display(), far.log);
    fs::write(folder.path().join("nowhere"), "a file, where a folder would have to be").unwrap();
    assert!(crate::fails(folder.path(), &line, 2).contains("nowhere"));
    fs::remove_file(folder.path().join("nowhere")).unwrap();
    let line = format!("record --elf {} --tcp 127.0.0.1:1 --out rec.csv", elf.display());
    assert!(crate::fails(folder.path(), &line, 4).contains("127.0.0.1:1: "));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_run_is_recorded_over_the_link_without_a_probe_or_the_image_and_replays() {
    let far = Far::start(None);
    let folder = tempfile::tempdir().unwrap();
    let said = printed(folder.path(), &far.line("run chirp --duration-s 1 --enable --record run.csv"));
    assert!(said.contains("stopped\nwrote run.csv: "), "{said}");
    let recorded = fs::read_to_string(folder.path().join("run.csv")).unwrap();
    assert!(recorded.lines().count() > 100 && recorded.contains(",damper,"), "it moved");
    let replayed = printed(folder.path(), "replay run.csv");
    assert!(replayed.contains("identical"), "{replayed}");

    let said = printed(folder.path(), &format!("record --tcp {} --for-s 0.5 --out rest.csv", far.link));
    assert!(said.ends_with(" rows, the time was over\n"), "{said}");
    assert!(printed(folder.path(), "replay rest.csv").contains("identical"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "the temporary files are gone");

    let missing = crate::lab(folder.path(), "record rtt.bin --out log.csv");
    let said = String::from_utf8(missing.stderr).unwrap();
    assert!(missing.status.code() == Some(2) && said.contains("--elf <IMAGE>"), "{said}");
}

#[test]
fn what_came_before_a_drive_fell_silent_is_kept() {
    let far = Far::start(None);
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("servo-lab"));
    command.current_dir(folder.path()).args(["record", "--tcp", &far.link.to_string(), "--out", "rec.csv"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_until("rows are written", || growing(folder.path()) > 0);
    drop(far);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(4), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(fs::read_to_string(folder.path().join("rec.csv")).unwrap().lines().count() > 1);
}
