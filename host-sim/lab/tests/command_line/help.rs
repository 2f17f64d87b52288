//! What `--help`, `help` and the man pages say of every command.

use std::fs;
use std::path::Path;

use crate::{lab, printed};

#[test]
fn help_lists_every_command_and_flag() {
    let folder = tempfile::tempdir().unwrap();
    let help = printed(folder.path(), "--help");
    for command in ["simulate", "replay", "compare", "stability", "demo"] {
        assert!(help.contains(&format!("\n  {command} ")), "{command} in {help}");
        let help = printed(folder.path(), &format!("{command} --help"));
        assert!(help.contains("Usage: servo-lab"), "{help}");
    }
    let help = printed(folder.path(), "simulate --help");
    for word in ["step", "steps", "multisine", "chirp", "ramp", "disturbance", "--reference", "--seed", "--machine"] {
        assert!(help.contains(word), "{word} in {help}");
    }
}

/// That the help of a command and of each below it has an example that names it, and the global flags; how many there are.
fn has_an_example(folder: &Path, path: &str) -> usize {
    let help = printed(folder, &format!("{path} --help"));
    let example = help.split("Example:\n").nth(1).unwrap_or_default();
    let named = |line: &&str| {
        let mut words = line.split_whitespace();
        line.starts_with("  servo-lab ") && path.split(' ').all(|name| words.any(|word| word == name))
    };
    assert!(example.lines().any(|line| named(&line)), "{path}: {help}");
    assert!(help.contains("--quiet") && help.contains("--verbose"), "{path}");
    assert!(printed(folder, &format!("help {path}")).ends_with(&format!("Example:\n{example}")), "{path}");
    let below = help.split("Commands:\n").nth(1).unwrap_or_default().split("\n\n").next().unwrap();
    let names = below.lines().filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    let names = names.filter(|name| !name.is_empty());
    1 + names.map(|name| has_an_example(folder, &format!("{path} {name}"))).sum::<usize>()
}

#[test]
fn every_command_has_an_example_and_the_global_flags() {
    let folder = tempfile::tempdir().unwrap();
    let help = printed(folder.path(), "--help");
    let commands = help.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let names: Vec<&str> = commands.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.len() > 18, "{names:?}");
    assert!(has_an_example(folder.path(), "link") > 20, "actions of link");
    for name in names {
        has_an_example(folder.path(), name);
    }
    let took = lab(folder.path(), "simulate --duration-s 0.1 --verbose");
    assert!(String::from_utf8_lossy(&took.stderr).contains("took "), "{took:?}");
    assert!(printed(folder.path(), "simulate --duration-s 0.1 --quiet").starts_with("step "));
}

/// One option has one name in every command, and its other names are known, too.
#[test]
fn frequencies_and_angles_have_the_same_names_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str| printed(folder.path(), line);
    let one = run("simulate chirp --low-hz 1 --high-hz 2 --amplitude-deg 5 --duration-s 1");
    assert_eq!(run("simulate chirp --from-hz 1 --to-hz 2 --amplitude-deg 5 --duration-s 1"), one);
    assert_eq!(run("simulate ramp --travel-deg 5"), run("simulate ramp --amplitude-deg 5"));
    for (shape, names) in [
        ("multisine", ["--low-hz", "from-hz", "--high-hz", "to-hz", "--tones"]),
        ("chirp", ["low-hz", "--from-hz", "high-hz", "--to-hz", "--amplitude-deg"]),
        ("ramp", ["--travel-deg", "amplitude-deg", "--speed-rad-s", "--duration-s", "--help"]),
    ] {
        let help = run(&format!("link --port none run {shape} --help"));
        assert!(names.iter().all(|name| help.contains(name)), "{shape}: {help}");
    }
}

/// The names that flags had before are not listed, and do what they did.
#[test]
fn flags_have_one_name_in_every_help_and_keep_the_earlier_ones() {
    let folder = tempfile::tempdir().unwrap();
    let run = |line: &str| printed(folder.path(), line);
    for (line, earlier) in [
        (
            "stability --drive-delay-ms 4 --fluid lag --lag-ms 3",
            "stability --delay-ms 4 --model lag --field-delay-ms 3",
        ),
        ("stability --dead-time-ms 4", "stability --model dead-time --field-delay-ms 4"),
        ("stability --fluid dead-time --dead-time-ms 4", "stability --dead-time-ms 4"),
    ] {
        assert_eq!(run(line), run(earlier), "{line}");
    }
    for (command, names, earlier) in [
        (
            "stability",
            vec!["--drive-delay-ms", "--dead-time-ms", "--lag-ms", "--fluid"],
            vec![" --delay-ms", "--model"],
        ),
        ("record", vec!["--duration-s"], vec!["--for-s"]),
        ("link enable", vec!["--duration-s"], vec!["--for-s"]),
        ("link reference", vec!["--speed-rad-s", "--acceleration-rad-s2"], vec!["--speed ", "--accel ", "--for-s"]),
    ] {
        let help = run(&format!("help {command}"));
        assert!(names.iter().all(|name| help.contains(name)), "{command}: {help}");
        assert!(!earlier.iter().any(|name| help.contains(name)), "{command}: {help}");
    }
    for command in ["decode", "tune", "paper", "guide", "demo", "man", "prove", "commission", "link identify"] {
        assert!(run(&format!("help {command}")).contains("-o, --out"), "{command}");
    }
}

#[test]
fn every_command_and_every_action_has_a_man_page() {
    let folder = tempfile::tempdir().unwrap();
    printed(folder.path(), "man -o man");
    for (page, says) in
        [("servo-lab", "servo\\-lab"), ("servo-lab-link-run", "link run"), ("servo-lab-link-run-chirp", "sine")]
    {
        let text = fs::read_to_string(folder.path().join("man").join(format!("{page}.1"))).unwrap();
        assert!(text.contains(says), "{page}: {text}");
    }
}
