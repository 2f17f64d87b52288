//! Real machines with an effect concealed from their nominal model: the answer beside what is published, or what was
//! measured separately.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::text::Table;
use super::tool::{Question, Tool};
use super::{Answer, Verdict};
use crate::read::Machine;
use crate::{Error, output};

/// Orders of the cogging that the separate measurement is asked for.
const ORDERS: [f64; 6] = [7.0, 28.0, 14.0, 36.0, 12.0, 24.0];

/// A value known from elsewhere, and what was answered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Known {
    /// Effect and parameter, with its order where it has several.
    pub what: String,
    /// From elsewhere.
    pub truth: f64,
    /// From where.
    pub source: String,
    /// Answered: estimate and 95 % interval; none where the answer has no such parameter.
    pub answered: Option<[f64; 3]>,
}

/// What came of one real case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RealOutcome {
    /// Case.
    pub name: String,
    /// What the nominal model leaves out.
    pub concealed: String,
    /// The tool's conclusion.
    pub verdict: Verdict,
    /// Names, by evidence.
    pub named: Vec<String>,
    /// Value by value.
    pub known: Vec<Known>,
    /// Held-out error before and after, and the floor, in the unit.
    pub heldout: [Option<f64>; 3],
    /// See above.
    pub unit: String,
}

/// A case: which files, and what is taken from the model.
struct RealCase {
    name: &'static str,
    concealed: &'static str,
    folder: &'static str,
    conceal: fn(&mut Machine),
    fitted: &'static [&'static str],
    held_out: &'static str,
    truth: fn(&Path) -> Result<Vec<Sourced>, Error>,
}

/// A true value and where it is from.
type Sourced = (Truth, String);

/// Effect, parameter, order a revolution where there are several, value.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Truth(&'static str, &'static str, Option<f64>, f64);

const CASES: [RealCase; 4] = [
    RealCase {
        name: "EMPS, friction left out",
        concealed: "dry friction, offset",
        folder: "emps",
        conceal: |_| (),
        fitted: &["train.csv"],
        held_out: "pulses.csv",
        truth: |_| Ok(published(&[Truth("coulomb_friction", "coulomb_n", None, 20.39), OFFSET])),
    },
    RealCase {
        name: "EMPS, viscous friction left out",
        concealed: "viscous friction, offset",
        folder: "emps",
        conceal: |machine| (machine.plant.viscous, machine.plant.coulomb) = (0.0, 20.39),
        fitted: &["train.csv"],
        held_out: "pulses.csv",
        truth: |_| Ok(published(&[Truth("viscous_friction", "viscous_n_s_m", None, 203.5034), OFFSET])),
    },
    RealCase {
        name: "direct-drive motor, cogging left out",
        concealed: "cogging",
        folder: "odrive_cogging",
        conceal: |_| (),
        fitted: &["slow2_nocomp_0.csv", "slow2_nocomp_1.csv"],
        held_out: "slow2_nocomp_2.csv",
        truth: map,
    },
    RealCase {
        name: "direct-drive motor, slower",
        concealed: "cogging",
        folder: "odrive_cogging",
        conceal: |_| (),
        fitted: &["slow2_slower_nocomp_0.csv"],
        held_out: "slow2_nocomp_2.csv",
        truth: map,
    },
];

/// The published offset stands on the side of the drag; the tool's on that of the drive.
const OFFSET: Truth = Truth("torque_offset", "offset_n", None, 3.165);

fn published(values: &[Truth]) -> Vec<Sourced> {
    values.iter().map(|value| (*value, "Janot, Gautier, Brunot 2019".to_owned())).collect()
}

/// Amplitudes of the holding torque over one revolution, as two maps of the same motor have them.
fn map(folder: &Path) -> Result<Vec<Sourced>, Error> {
    let (fine, coarse) = (amplitudes(&folder.join("map_a_4.csv"))?, amplitudes(&folder.join("map_rev_16.csv"))?);
    let value = |((order, fine), coarse): ((&f64, f64), f64)| {
        let truth = Truth("cogging", "amplitude_nm", Some(*order), fine);
        (truth, format!("map_a_4.csv; map_rev_16.csv has {coarse:.5}"))
    };
    Ok(ORDERS.iter().zip(fine).zip(coarse).map(value).collect())
}

/// Amplitude of each order in a map of `position_rad, holding_torque_nm` over whole revolutions.
fn amplitudes(file: &Path) -> Result<Vec<f64>, Error> {
    let wrong = |message: String| Error::input(file, None, "", message);
    let mut reader = csv::Reader::from_path(file).map_err(|error| wrong(error.to_string()))?;
    let rows: Result<Vec<(f64, f64)>, _> = reader.deserialize().collect();
    let rows = rows.map_err(|error| wrong(error.to_string()))?;
    let amplitude = |order: &f64| {
        let sum = |wave: fn(f64) -> f64| rows.iter().map(|(at, nm)| nm * wave(order * at)).sum::<f64>();
        2.0 / rows.len().max(1) as f64 * sum(f64::sin).hypot(sum(f64::cos))
    };
    Ok(ORDERS.iter().map(amplitude).collect())
}

/// Runs every case whose data is in the folder; says of the others why there is no answer.
pub fn run(data: &Path, out: &Path, tool: &Tool) -> (Vec<RealOutcome>, Vec<String>) {
    let (mut outcomes, mut skipped) = (Vec::new(), Vec::new());
    for (number, case) in CASES.iter().enumerate() {
        let folder = data.join(case.folder);
        if !folder.is_dir() {
            skipped.push(format!("{} skipped: {} is not there", case.name, folder.display()));
            continue;
        }
        match one(case, &folder, &out.join("real").join(number.to_string()), tool) {
            Ok(outcome) => outcomes.push(outcome),
            Err(error) => skipped.push(format!("{} without an answer: {error}", case.name)),
        }
    }
    (outcomes, skipped)
}

fn one(case: &RealCase, data: &Path, out: &Path, tool: &Tool) -> Result<RealOutcome, Error> {
    output::folder(out)?;
    let mut machine = Machine::read(&data.join("machine.toml"))?;
    (case.conceal)(&mut machine);
    machine.write(&out.join("machine.toml"))?;
    let missing = |error: std::io::Error| Error::input(data, None, "", error.to_string());
    let data = data.canonicalize().map_err(missing)?;
    let files: Vec<PathBuf> = case.fitted.iter().chain([&case.held_out]).map(|name| data.join(name)).collect();
    let mut names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
    let held_out = names.pop().unwrap_or_default();
    let question = Question {
        machine: "machine.toml",
        recordings: names.iter().map(String::as_str).collect(),
        holdout: vec![&held_out],
        ..Question::default()
    };
    let answer = tool.ask(out, "answer", &question)?;
    let known = (case.truth)(&data)?.into_iter().map(|(truth, source)| known(truth, source, &answer)).collect();
    let fit = &answer.fit;
    Ok(RealOutcome {
        name: case.name.to_owned(),
        concealed: case.concealed.to_owned(),
        verdict: answer.verdict,
        named: answer.effects.iter().map(|effect| effect.id.clone()).collect(),
        known,
        heldout: [fit.heldout_before_rms, fit.heldout_after_rms, fit.noise_floor_rms],
        unit: fit.unit.clone(),
    })
}

fn known(Truth(id, parameter, order, truth): Truth, source: String, answer: &Answer) -> Known {
    let what = order.map_or_else(|| format!("{id}.{parameter}"), |order| format!("{id}.{parameter}, order {order}"));
    Known { what, truth, source, answered: estimate(answer, id, parameter, order) }
}

/// The estimate of a parameter; of several orders, the one beside that order.
fn estimate(answer: &Answer, id: &str, parameter: &str, order: Option<f64>) -> Option<[f64; 3]> {
    for effect in answer.effects.iter().filter(|effect| effect.id == id) {
        // An entry of each order: its parameters follow each other, amplitude first.
        for entry in effect.parameters.chunk_by(|_, next| next.id != effect.parameters[0].id) {
            let find = |name: &str| entry.iter().find(|found| found.id == name);
            let meant = order.is_none_or(|order| {
                find("order_per_rev").and_then(|found| found.value).is_some_and(|value| (value - order).abs() < 0.25)
            });
            if let Some(found) = find(parameter).filter(|_| meant) {
                return Some([found.value?, found.low?, found.high?]);
            }
        }
    }
    None
}

/// The outcomes as a table.
pub fn table(outcomes: &[RealOutcome]) -> Table {
    let head = vec![
        "machine",
        "concealed",
        "answered",
        "held-out error before, after, floor",
        "value",
        "known",
        "answered value",
        "from",
    ];
    let rows = outcomes.iter().flat_map(|outcome| {
        let number = |value: &Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3e}"));
        let heldout: Vec<String> = outcome.heldout.iter().map(number).collect();
        let answer = format!("{}: {}", outcome.verdict.name(), outcome.named.join(" + "));
        outcome.known.iter().map(move |known| {
            let value = known.answered.map_or_else(
                || "not named".to_owned(),
                |[value, low, high]| format!("{value:.5} [{low:.5}, {high:.5}]"),
            );
            let heldout = format!("{} {}", heldout.join(", "), outcome.unit);
            let (what, truth) = (known.what.clone(), format!("{:.5}", known.truth));
            vec![
                outcome.name.clone(),
                outcome.concealed.clone(),
                answer.clone(),
                heldout,
                what,
                truth,
                value,
                known.source.clone(),
            ]
        })
    });
    (head, rows.collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn the_amplitude_of_an_order_is_found_in_a_map() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("map.csv");
        let row = |k: usize| {
            let at = TAU * k as f64 / 512.0;
            format!("{at},{}\n", 0.05 * (7.0 * at + 1.0).sin() + 0.02 * (28.0 * at).cos() + 0.3)
        };
        let text = (0..512).map(row).collect::<String>();
        std::fs::write(&file, format!("position_rad,holding_torque_nm\n{text}")).unwrap();
        let found = amplitudes(&file).unwrap();
        assert!((found[0] - 0.05).abs() < 1e-9 && (found[1] - 0.02).abs() < 1e-9 && found[2].abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn the_estimate_beside_an_order_is_taken() {
        let answer = r#"{"verdict": "named", "effects": [{"id": "cogging", "parameters": [
            {"id": "amplitude_nm", "value": 0.1, "low": 0.09, "high": 0.11}, {"id": "order_per_rev", "value": 7, "low": 7, "high": 7},
            {"id": "amplitude_nm", "value": 0.2, "low": 0.19, "high": 0.21}, {"id": "order_per_rev", "value": 28, "low": 28, "high": 28}
            ]}]}"#;
        let answer: Answer = serde_json::from_str(answer).unwrap();
        assert_eq!(estimate(&answer, "cogging", "amplitude_nm", Some(28.0)), Some([0.2, 0.19, 0.21]));
        assert_eq!(estimate(&answer, "cogging", "amplitude_nm", Some(12.0)), None);
        assert_eq!(estimate(&answer, "cogging", "amplitude_nm", None), Some([0.1, 0.09, 0.11]));
    }
}
