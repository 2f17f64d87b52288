//! What a user sees on a terminal: how far a diagnosis is, and colours where they are wanted.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use assert_cmd::Command;
use diagnosis::effects::VOCABULARY;
use lab::conclude::of_files;
use lab::progress::{Course, End, Line, Look, Place};

const MACHINE: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 1e-3\nresolution = 1.3e-5\n\
                       [plant]\ninertia = 0.075\ncoulomb = 0.763\ntorque_limit = 30.0\ntorque_delay_s = 0.005\n";

/// A machine file and a recording of an axis with more friction than it says.
fn axis(folder: &Path) -> [PathBuf; 2] {
    let [machine, real, log] = ["m.toml", "real.toml", "run.csv"].map(|name| folder.join(name));
    std::fs::write(&machine, MACHINE).unwrap();
    std::fs::write(&real, MACHINE.replace("0.763", "1.2")).unwrap();
    let words = ["simulate", "steps", "--machine", "real.toml", "--duration-s", "3", "--torque-noise-nm", "0.02"];
    let mut simulate = Command::cargo_bin("servo-lab").unwrap();
    assert!(simulate.current_dir(folder).args(words).args(["-o", "run.csv"]).output().unwrap().status.success());
    [machine, log]
}

/// Looks every millisecond, and keeps each place that is another than the one before.
#[derive(Clone, Default)]
struct Watcher {
    look: Arc<Mutex<Option<Look>>>,
    seen: Arc<Mutex<Vec<Place>>>,
}

impl std::fmt::Debug for Watcher {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Watcher").finish_non_exhaustive()
    }
}

impl Line for Watcher {
    fn enter(&self, look: Look) {
        let mut shown = self.look.lock().unwrap();
        self.note(shown.as_ref());
        *shown = Some(look);
        self.note(shown.as_ref());
    }
}

impl Watcher {
    fn note(&self, look: Option<&Look>) {
        let Some(place) = look.map(|look| look()) else { return };
        let mut seen = self.seen.lock().unwrap();
        if seen.last() != Some(&place) {
            seen.push(place);
        }
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn the_count_of_work_rises_through_search_and_estimate_and_changes_no_answer() {
    let folder = tempfile::tempdir().unwrap();
    let [machine, log] = axis(folder.path());
    let (watcher, ended) = (Watcher::default(), Arc::new(AtomicBool::new(false)));
    let looking = {
        let (watcher, ended) = (watcher.clone(), Arc::clone(&ended));
        thread::spawn(move || {
            while !ended.load(Ordering::Relaxed) {
                watcher.note(watcher.look.lock().unwrap().as_ref());
                thread::sleep(Duration::from_millis(1));
            }
        })
    };
    let answer = |course: &Course| {
        of_files(&machine, std::slice::from_ref(&log), &[], &VOCABULARY, course).unwrap().diagnosis.answer
    };
    let watched = answer(&Course::on(watcher.clone()));
    ended.store(true, Ordering::Relaxed);
    looking.join().unwrap();
    assert_eq!(watched, answer(&Course::unseen()));
    assert!(watched.effects.iter().any(|effect| effect.id == "coulomb_friction"), "{watched:?}");

    let seen = watcher.seen.lock().unwrap();
    let mut stages: Vec<&str> = seen.iter().map(|place| place.stage).collect();
    stages.dedup();
    assert!(stages.starts_with(&["reading", "preparing", "search", "estimate"]), "{stages:?}");
    let working: Vec<&Place> = seen.iter().filter(|place| ["search", "estimate"].contains(&place.stage)).collect();
    assert!(working.is_sorted_by(|a, b| a.done <= b.done && a.end == b.end), "{working:?}");
    let (first, last) = (working[0], working[working.len() - 1]);
    let End::AtMost { steps, usually, .. } = first.end else { panic!("{first:?}") };
    assert!(working.len() > 10 && first.done < last.done && last.done < steps, "{working:?}");
    // What is usual is within a factor of ten of what it took.
    assert!(usually < steps && last.done > usually / 10 && last.done < 10 * usually, "{usually}: {last:?}");
}

#[cfg(unix)]
mod terminal {
    use std::fs::File;
    use std::io::Read;
    use std::process::{Command, Stdio};
    use std::time::Instant;

    use nix::pty::{OpenptyResult, Winsize, openpty};

    use super::*;

    /// Which stream is a terminal; the other leads nowhere.
    #[derive(PartialEq)]
    enum Terminal {
        Output,
        Error,
    }

    /// What `servo-lab` shows on a terminal, with that in its environment, and after how many seconds this word was there.
    fn shown(folder: &Path, words: &[&str], on: Terminal, set: &[(&str, &str)], word: &str) -> (String, Option<f64>) {
        let size = Winsize { ws_row: 24, ws_col: 100, ws_xpixel: 0, ws_ypixel: 0 };
        let OpenptyResult { master, slave } = openpty(Some(&size), None).unwrap();
        let mut command = Command::new(assert_cmd::cargo::cargo_bin("servo-lab"));
        command.current_dir(folder).args(words).env("TERM", "xterm").env_remove("NO_COLOR").envs(set.iter().copied());
        let (stdout, stderr) = match on {
            Terminal::Output => (Stdio::from(slave), Stdio::null()),
            Terminal::Error => (Stdio::null(), Stdio::from(slave)),
        };
        let begun = Instant::now();
        let mut child = command.stdin(Stdio::null()).stdout(stdout).stderr(stderr).spawn().unwrap();
        // The terminal ends when nobody has it any more.
        drop(command);
        let (mut terminal, mut text, mut first) = (File::from(master), Vec::new(), None);
        let mut part = [0; 4096];
        // A terminal that has ended is an error on Linux.
        while let Some(count) = terminal.read(&mut part).ok().filter(|count| *count > 0) {
            text.extend_from_slice(&part[..count]);
            if first.is_none() && String::from_utf8_lossy(&text).contains(word) {
                first = Some(begun.elapsed().as_secs_f64());
            }
        }
        assert!(child.wait().unwrap().success());
        (String::from_utf8_lossy(&text).into_owned(), first)
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
    fn a_diagnosis_shows_its_stages_from_the_first_second_and_nothing_if_quiet() {
        let folder = tempfile::tempdir().unwrap();
        axis(folder.path());
        let words = ["diagnose", "--machine", "m.toml", "run.csv"];
        let (text, first) = shown(folder.path(), &words, Terminal::Error, &[], "gone");
        println!("first after {first:?} s:\n{text}");
        assert!(first.is_some_and(|first_s| first_s < 1.0), "{first:?} s: {text}");
        assert!(text.contains("diagnosis: search, ") && text.contains("s gone"), "{text}");
        assert!(!is_coloured(&text), "{text:?}");
        let quiet = [&words[..], &["--quiet"]].concat();
        let (quiet, _) = shown(folder.path(), &quiet, Terminal::Error, &[], "gone");
        assert!(quiet.is_empty(), "{quiet}");
    }

    /// Beside what has a count: nothing within it has a line of its own, nothing wraps, nothing moves the cursor up.
    #[test]
    #[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
    fn a_fleet_and_the_guide_show_how_far_they_are_on_one_line() {
        let folder = tempfile::tempdir().unwrap();
        axis(folder.path());
        let rows = "m.toml,run.csv\n".repeat(3);
        std::fs::write(folder.path().join("list.csv"), format!("machine,recordings\n{rows}")).unwrap();
        let fleet = ["fleet", "list.csv", "-o", "fleet.parquet", "--jobs", "1"];
        let guide = ["guide", "--only", "coulomb_friction,backlash,compliance"];
        for (words, says) in [
            (&fleet[..], ["fleet, rows diagnosed: ", " of 3, "]),
            // How many are done when the line comes, after its first second, is a matter of the machine's speed.
            (&guide, ["field guide, effects: ", " of 3, "]),
        ] {
            let (text, first) = shown(folder.path(), words, Terminal::Error, &[], "gone");
            println!("first after {first:?} s:\n{text}");
            assert!(first.is_some_and(|first_s| first_s < 5.0), "{first:?} s: {text}");
            assert!(says.iter().all(|says| text.contains(says)), "{text}");
            assert!(!text.contains("\x1b[1A") && !text.contains("ticks"), "{text:?}");
            // Rows that are done are not done again.
            let _ = std::fs::remove_file(folder.path().join("fleet.parquet"));
            let quiet = [words, &["--quiet", "--force"]].concat();
            assert_eq!(shown(folder.path(), &quiet, Terminal::Error, &[], "gone").0, "");
        }
    }

    /// Whether a text asks a terminal for colours or weights, beside where its cursor is.
    fn is_coloured(text: &str) -> bool {
        let codes = text.split("\x1b[").skip(1);
        codes
            .filter_map(|code| code.find(|letter: char| letter.is_alphabetic()).map(|at| &code[..=at]))
            .any(|code| code.ends_with('m'))
    }

    #[test]
    fn help_is_coloured_on_a_terminal_and_never_with_no_color() {
        let folder = tempfile::tempdir().unwrap();
        let help = |set: &[(&str, &str)]| shown(folder.path(), &["--help"], Terminal::Output, set, "Usage").0;
        let (coloured, plain) = (help(&[]), help(&[("NO_COLOR", "1")]));
        assert!(is_coloured(&coloured) && coloured.contains("Usage"), "{coloured:?}");
        assert!(!is_coloured(&plain) && plain.contains("Usage"), "{plain:?}");
    }
}
