//! How often 95 % intervals hold the truth, with the structure known. Run by name; it prints.

use diagnosis::effects::find;
use lab::conclude::{Request, diagnose};

use crate::cases::{COUNT_RAD, machine, recordings};

/// Effect with its values.
const CASES: [(&str, &[f64]); 5] = [
    ("coulomb_friction", &[0.80]),
    ("field_lag", &[0.0036]),
    ("torque_gain", &[0.985]),
    ("stribeck_friction", &[0.5, 0.1]),
    ("viscous_friction", &[0.02]),
];

#[test]
#[ignore = "prints a table, takes minutes: cargo test --release -p lab --test diagnosis coverage -- --ignored --nocapture"]
fn coverage_of_intervals() {
    let number = |name: &str, usual: f64| -> f64 {
        std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
    };
    let (first, seeds, noise) = (number("FIRST", 1.0) as u64, number("SEEDS", 20.0) as u64, number("NOISE", 0.05));
    let only = std::env::var("CASE").ok();
    for (id, truth) in CASES {
        if only.as_ref().is_some_and(|only| !only.split(',').any(|o| o == id)) {
            continue;
        }
        // Of each value: intervals that hold the truth, errors, squares of errors, half-widths.
        let mut sums = vec![[0.0; 4]; truth.len()];
        let mut named = 0;
        for seed in first..first + seeds {
            let files = recordings(&|physics| (find(id).unwrap().put)(physics, truth), 100 + seed, noise);
            let machine = machine(COUNT_RAD);
            let vocabulary = [find(id).unwrap()];
            let request = Request { machine: &machine, recordings: &files[..2], holdout: &[], vocabulary: &vocabulary };
            let answer = diagnose(&request).unwrap().answer;
            let Some(effect) = answer.effects.first() else { continue };
            named += 1;
            for ((sums, parameter), truth) in sums.iter_mut().zip(&effect.parameters).zip(truth) {
                let error = parameter.value - truth;
                let held = f64::from(u8::from(parameter.low <= *truth && *truth <= parameter.high));
                let parts = [held, error, error * error, 0.5 * (parameter.high - parameter.low)];
                sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
            }
        }
        for [held, error, squares, half] in sums {
            let count = f64::from(named.max(1));
            println!(
                "{id:20} named {named} of {seeds}, interval holds the truth in {:.0} %; bias {:.2e}, rms error {:.2e}, \
                 mean half-width {:.2e}",
                100.0 * held / count,
                error / count,
                (squares / count).sqrt(),
                half / count
            );
        }
    }
}
