//! Whatever logs and machine files it is fed, servo-lab answers: exit code 0, or 2 with one message; it never panics, and
//! every command ends within a minute on one core.
//!
//! Seeded: real and simulated recordings, thinned out, cut, scaled in time and position, their columns held constant,
//! swapped, negated, made NaN or huge; machine files with a number at the end of what a double holds. The short form runs
//! with the tests, the long one with `cargo xtask fuzz`.

use std::fs;
use std::path::Path;

use crate::common::{Ended, run, shared};
use diagnosis::effects::find;
use diagnosis::physics::Physics;
use lab::read::Machine;
use lab::report::{Answer, EffectAnswer};
use rand::rngs::StdRng;
use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};

/// Of the cases; the same each time, unless this variable of the environment has another.
const SEED: u64 = 20_261_123;
const SEED_VARIABLE: &str = "SWEEP_SEED";
/// Cases of the short form: less than a minute on two cores.
const SHORT: u32 = 60;
/// Cases of the long form.
const LONG: u32 = 2000;

/// Numbers at the ends of what a key may hold, and beyond.
const EXTREMES: [&str; 12] =
    ["0", "5e-324", "1e-300", "1e-12", "1e-6", "1e-3", "1e3", "1e6", "1e12", "1e300", "1.7e308", "-1e300"];

const MACHINE: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\nresolution = 1.3e-5\n\
                       [plant]\ninertia = 0.075\ncoulomb = 0.763\nviscous = 0.01\ntorque_limit = 30.0\n\
                       torque_delay_s = 0.005\n[plant.er]\na = 0.0704\nb = 0.47\ndead_time_s = 0.002\nlag_s = 0.003\n";
/// An effect that a machine file of a sweep may have.
const EFFECTS: [&str; 8] = [
    "id = \"backlash\"\ngap_rad = 1e-3\nresonance_hz = 60.0\ndamping_ratio = 0.05\ninertia_ratio = 0.4\n",
    "id = \"compliance\"\nresonance_hz = 60.0\ndamping_ratio = 0.05\ninertia_ratio = 0.4\n",
    "id = \"presliding\"\nstiffness_nm_rad = 1e4\n",
    "id = \"er_preyield\"\nstiffness_nm_rad = 1e3\n",
    "id = \"quadratic_drag\"\ncoefficient_nm_s2_rad2 = 0.1\n",
    "id = \"stribeck_friction\"\nexcess_nm = 0.2\nvelocity_rad_s = 0.1\n",
    "id = \"cogging\"\namplitude_nm = 0.1\norder_per_rev = 7.0\nphase_rad = 0.0\n",
    "id = \"torque_lag\"\nlag_s = 1e-3\n",
];

/// Folders of the real recordings with machine files and recordings of each, which go with each other.
type Set = (&'static str, &'static [&'static str], &'static [&'static str]);
const SETS: [Set; 5] = [
    ("emps", &["machine"], &["train", "pulses"]),
    ("odrive_cogging", &["machine"], &["slow2_comp_0", "slow2_nocomp_0", "slow2_nocomp_1", "slow2_slower_nocomp_0"]),
    ("dfki", &["heavy_full", "heavy_no_gravity", "heavy_none"], &["ddp", "dircol", "energy", "ilqr"]),
    ("weigand", &["j1_full", "j1_no_friction"], &["j1_A", "j1_B", "j1_C"]),
    ("weigand", &["j6_full", "j6_no_friction"], &["j6_A", "j6_B", "j6_C"]),
];

/// A recording with the machine file that belongs to it.
struct Base {
    name: String,
    machine: String,
    recording: Vec<String>,
}

fn bases(folder: &Path) -> Vec<Base> {
    let lines = |file: &Path| fs::read_to_string(file).unwrap().lines().map(str::to_owned).collect();
    let made = folder.join("made.csv");
    let mut all = Vec::new();
    for scenario in ["steps", "multisine"] {
        let status =
            run(folder, &["simulate", scenario, "--duration-s", "3", "--torque-noise-nm", "0.05", "-o", "made.csv"])
                .output;
        assert!(status.status.success(), "{status:?}");
        all.push(Base { name: scenario.to_owned(), machine: MACHINE.to_owned(), recording: lines(&made) });
        fs::remove_file(&made).unwrap();
    }
    let Some(data) = shared() else { return all };
    for (set, machines, recordings) in SETS {
        for (machine, recording) in machines.iter().flat_map(|one| recordings.iter().map(move |other| (one, other))) {
            all.push(Base {
                name: format!("{set} {machine} {recording}"),
                machine: fs::read_to_string(data.join(set).join(format!("{machine}.toml"))).unwrap(),
                recording: lines(&data.join(set).join(format!("{recording}.csv"))),
            });
        }
    }
    all
}

/// The recording of a case: rows and columns bent.
fn bent(random: &mut StdRng, lines: &[String], most_rows: usize, said: &mut String) -> String {
    let mut header: Vec<&str> = lines[0].split(',').collect();
    let every = random.random_range(1..=20);
    let rows = [5, 8, 20, 60, 200, 1000, usize::MAX].choose(random).copied().unwrap().min(most_rows);
    let body = lines[1..].iter().step_by(every).take(rows);
    let mut cells: Vec<Vec<String>> = body.map(|line| line.split(',').map(str::to_owned).collect()).collect();
    said.push_str(&format!("every {every}, {} rows", cells.len()));
    for place in [0, header.iter().position(|name| name.starts_with("position")).unwrap()] {
        if random.random_ratio(1, 3) {
            let factor = 10.0_f64.powi(random.random_range(-6..=6));
            said.push_str(&format!(", {} times {factor:e}", header[place]));
            for row in &mut cells {
                row[place] = (row[place].parse::<f64>().unwrap() * factor).to_string();
            }
        }
    }
    if random.random_ratio(1, 2) {
        let (column, other) = (random.random_range(0..header.len()), random.random_range(0..header.len()));
        let kind = random.random_range(0..6);
        said.push_str(&format!(", {} bent by {kind}", header[column]));
        if kind == 0 {
            header.swap(column, other);
        }
        let first = cells[0][column].clone();
        for row in &mut cells {
            let value = row[column].clone();
            row[column] = match kind {
                1 => first.clone(),
                2 => value.parse::<f64>().map_or(value, |number| (-number).to_string()),
                3 if random.random_ratio(1, 50) => "NaN".to_owned(),
                4 if random.random_ratio(1, 50) => "1e300".to_owned(),
                5 => value.parse::<f64>().map_or(value, |number| (1e150 * number).to_string()),
                _ => value,
            };
        }
    }
    let rows: Vec<String> = cells.iter().map(|row| row.join(",")).collect();
    format!("{}\n{}\n", header.join(","), rows.join("\n"))
}

/// The machine file of a case: one number at an end of its range, and an effect.
fn extreme(random: &mut StdRng, machine: &str, said: &mut String) -> String {
    let mut text = machine.to_owned();
    if random.random_ratio(1, 3) && machine.contains("rotary") {
        text.push_str(&format!("[[effects]]\n{}", EFFECTS.choose(random).unwrap()));
    }
    if random.random_ratio(1, 2) {
        return text;
    }
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let number = |line: &String| line.split_once(" = ").is_some_and(|(_, value)| value.trim().parse::<f64>().is_ok());
    let places: Vec<usize> = (1..lines.len()).filter(|&place| number(&lines[place])).collect();
    let place = *places.choose(random).unwrap();
    let key = lines[place].split(" = ").next().unwrap().to_owned();
    lines[place] = format!("{key} = {}", EXTREMES.choose(random).unwrap());
    said.push_str(&format!(", {}", lines[place]));
    lines.join("\n") + "\n"
}

/// What is wrong with how a command ended, or with what it says.
fn fault(ended: &Ended, machine: &Path) -> Option<String> {
    if ended.fault().is_some() || !ended.output.status.success() {
        return ended.fault();
    }
    let text = String::from_utf8_lossy(&ended.output.stdout);
    let mut words = text.split(|letter: char| !letter.is_alphanumeric());
    if let Some(word) = words.find(|word| ["NaN", "inf"].contains(word)) {
        return Some(format!("{word} in the answer: {text}"));
    }
    // Only a diagnosis prints JSON here; a number that is none is null in it, which no answer may have.
    if !text.starts_with('{') {
        return None;
    }
    match serde_json::from_str(&text) {
        Ok(answer) => misled(&answer, &Machine::read(machine).unwrap()),
        Err(error) => Some(format!("{error}: {text}")),
    }
}

/// An effect that is named though the interval of its leading value holds what it is without the effect.
fn misled(answer: &Answer, machine: &Machine) -> Option<String> {
    if !answer.verdict.is_certain() {
        return None;
    }
    let nominal = Physics::nominal(machine, &[]);
    let holds = |effect: &&EffectAnswer| {
        let Some(kind) = find(&effect.id) else { return false };
        let neutral = (kind.neutral)(&nominal);
        let mut leading = kind.leading.iter().filter_map(|&at| effect.parameters.get(at));
        leading.all(|value| value.low <= neutral && neutral <= value.high)
    };
    answer.effects.iter().find(holds).map(|effect| format!("named with an interval that holds the nominal: {effect:?}"))
}

/// One case after the other, each in a line with what it took; the faults are returned.
fn swept(cases: u32, most_rows: usize, commands: &[&[&str]]) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let bases = bases(folder.path());
    let (mut faults, mut slowest) = (Vec::new(), (0.0, String::new()));
    let seed = std::env::var(SEED_VARIABLE).map_or(SEED, |seed| seed.parse().unwrap());
    for case in 0..cases {
        let mut random = StdRng::seed_from_u64(seed + u64::from(case));
        let base = bases.choose(&mut random).unwrap();
        let arguments = *commands.choose(&mut random).unwrap();
        let mut said = format!("seed {}, {}: {}, ", seed + u64::from(case), arguments[0], base.name);
        let recording = bent(&mut random, &base.recording, most_rows, &mut said);
        let machine = extreme(&mut random, &base.machine, &mut said);
        fs::write(folder.path().join("case.csv"), recording).unwrap();
        fs::write(folder.path().join("case.toml"), machine).unwrap();
        let ended = run(folder.path(), arguments);
        let fault = fault(&ended, &folder.path().join("case.toml"));
        let code = ended.output.status.code();
        println!("{:.2} s, {:.2} s of processor, {code:?}, {said}{}", ended.wall_s, ended.cpu_s, marked(&fault));
        if ended.cpu_s > slowest.0 {
            slowest = (ended.cpu_s, said.clone());
        }
        faults.extend(fault.map(|fault| format!("{said}: {fault}")));
    }
    println!("{cases} cases from seed {seed}, {} faults; the slowest {:.1} s: {}", faults.len(), slowest.0, slowest.1);
    faults
}

fn marked(fault: &Option<String>) -> String {
    fault.as_ref().map_or_else(String::new, |fault| format!("\nFAULT {fault}"))
}

const COMPARE: &[&str] = &["compare", "--machine", "case.toml", "case.csv"];
const DIAGNOSE: &[&str] = &["diagnose", "--jobs", "1", "--machine", "case.toml", "case.csv", "--json", "-"];
const SIMULATE: &[&str] = &["simulate", "steps", "--machine", "case.toml", "--duration-s", "0.5"];
const STABILITY: &[&str] = &["stability", "--machine", "case.toml"];
const TUNE: &[&str] = &["tune", "--machine", "case.toml", "--out", "tuned"];

#[test]
#[cfg_attr(debug_assertions, ignore = "minutes without optimisation; the tests in release run it")]
fn a_bent_recording_or_machine_gets_an_answer_or_one_message() {
    let faults = swept(SHORT, 1000, &[COMPARE, DIAGNOSE, DIAGNOSE, SIMULATE, STABILITY]);
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

#[test]
#[ignore = "hours; cargo xtask fuzz runs it"]
fn every_bent_recording_and_machine_gets_an_answer_or_one_message() {
    let faults = swept(LONG, usize::MAX, &[COMPARE, DIAGNOSE, DIAGNOSE, SIMULATE, STABILITY, TUNE]);
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}
