//! Inertia, delays and times of the field by the likelihood of `diagnosis`.
//!
//! The two motions are fitted one after the other to begin with, and then together with friction, offset and strength of the
//! fluid free beside what is looked for: an interval then has in it what those could be.

use diagnosis::confidence_set::{Assessed, Interval, assess, intervals};
use diagnosis::effects::find;
use diagnosis::hypothesis::{Entry, Hypothesis, Refitted, refit};
use diagnosis::physics::Physics;
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use diagnosis::search::first_noise;
use er_servo::Config;

use super::momentum;
use super::report::nominal;
use super::steady::Steady;
use crate::Error;
use crate::read::Recording;

/// Inertia and delay of the motor.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// kg m2, to the scale of the commanded torque.
    pub inertia_kg_m2: Interval,
    /// From sample to acting torque, s.
    pub torque_delay_s: Interval,
}

/// How the field follows its command.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldTimes {
    /// From sample to the first change of the field, s.
    pub dead_time_s: Interval,
    /// Lag while it rises, s.
    pub rise_s: Interval,
    /// Lag while it falls, s; the same where the recordings do not tell them apart.
    pub fall_s: Interval,
}

impl FieldTimes {
    /// Whether it falls at another pace than it rises.
    pub fn is_asymmetric(&self) -> bool {
        self.rise_s != self.fall_s
    }
}

/// Rounds of a fit that is followed to its optimum, and of one that only has to show which start is best.
const ROUNDS: usize = 10;
const FIRST_ROUNDS: usize = 4;
/// Dead times, rises and falls that the fit of the field begins at, s: below and above the paper's 2 and 3 ms, and either way
/// asymmetric, for one lag in the place of two unlike ones is a valley of its own.
const STARTS_S: [(f64, [f64; 2]); 6] = [
    (0.0005, [0.001, 0.001]),
    (0.002, [0.003, 0.003]),
    (0.001, [0.010, 0.010]),
    (0.006, [0.002, 0.002]),
    (0.001, [0.003, 0.010]),
    (0.001, [0.010, 0.003]),
];

/// What the torques at constant speed tell and a motion tells too.
const BESIDE: [&str; 4] = ["coulomb_friction", "viscous_friction", "torque_offset", "er_strength"];

/// Inertia, delay of the motor and times of the field, from a motion without a field and one in which it is switched.
///
/// # Errors
///
/// Recordings that do not determine them.
pub(super) fn fit(
    before: &Config,
    steady: &Steady,
    motion: &Recording,
    steps: &Recording,
) -> Result<(Motion, FieldTimes), Error> {
    let (inertia, delay_s) = of_motion(before, steady, motion)?;
    let known = (inertia, delay_s);
    let (dead_time_s, lags_s) = of_field(before, steady, known, steps)?;
    let both = problem(before, steady, known, &[motion, steps]).finer();
    let together = |lag: (&'static str, Vec<f64>)| {
        let mut entries = vec![
            ("inertia", vec![inertia]),
            ("torque_delay", vec![delay_s]),
            ("field_dead_time", vec![dead_time_s]),
            lag,
        ];
        let machine = &both.nominal.model;
        let there = [machine.coulomb, machine.viscous, machine.torque_offset, 1.0];
        entries.extend(BESIDE.into_iter().zip(there.map(|value| vec![value])));
        let found = fitted(&both, &hypothesis(steps, &entries)?, ROUNDS).ok_or_else(|| vague(steps))?;
        assess(&both, found).ok_or_else(|| vague(steps))
    };
    let apart = together(("field_lag_asymmetry", lags_s.to_vec()))?;
    let lags = intervals(&apart, 3);
    if lags[0].high < lags[1].low || lags[1].high < lags[0].low {
        return Ok(told(&apart, lags[0], lags[1]));
    }
    let same = together(("field_lag", vec![0.5 * (lags_s[0] + lags_s[1])]))?;
    let lag = intervals(&same, 3)[0];
    Ok(told(&same, lag, lag))
}

/// What the likelihood resolves of a time, s: without any noise its fit of a machine whose times are known (the test of `link
/// identify`) is off by up to 2 us, for it computes in substeps. No interval of a time is narrower either way.
const RESOLVES_S: f64 = 3e-6;

fn time(interval: Interval) -> Interval {
    let Interval { value, low, high } = interval;
    Interval { value, low: low.min(value - RESOLVES_S), high: high.max(value + RESOLVES_S) }
}

fn told(found: &Assessed, rise_s: Interval, fall_s: Interval) -> (Motion, FieldTimes) {
    let of = |entry| intervals(found, entry)[0];
    (
        Motion { inertia_kg_m2: of(0), torque_delay_s: time(of(1)) },
        FieldTimes { dead_time_s: time(of(2)), rise_s: time(rise_s), fall_s: time(fall_s) },
    )
}

/// Inertia and delay to go on with.
fn of_motion(before: &Config, steady: &Steady, recording: &Recording) -> Result<(f64, f64), Error> {
    let begin = momentum::estimate(recording, steady, f64::from(before.period_s))?;
    let problem = problem(before, steady, begin, &[recording]);
    let start = hypothesis(recording, &[("inertia", vec![begin.0]), ("torque_delay", vec![begin.1])])?;
    let found = fitted(&problem, &start, ROUNDS).ok_or_else(|| vague(recording))?;
    Ok((value(&found, 0), value(&found, 1)))
}

/// Dead time, rise and fall of the field to go on with.
fn of_field(
    before: &Config,
    steady: &Steady,
    known: (f64, f64),
    recording: &Recording,
) -> Result<(f64, [f64; 2]), Error> {
    let problem = problem(before, steady, known, &[recording]);
    let mut best: Option<Refitted> = None;
    for (dead_time_s, lags_s) in STARTS_S {
        let start = [("field_dead_time", vec![dead_time_s]), ("field_lag_asymmetry", lags_s.to_vec())];
        let found = fitted(&problem, &hypothesis(recording, &start)?, FIRST_ROUNDS);
        best = best.into_iter().chain(found).max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood));
    }
    let best = best.ok_or_else(|| vague(recording))?;
    let lags_s = &best.hypothesis.entries[1].values;
    Ok((value(&best, 0), [lags_s[0], lags_s[1]]))
}

fn value(found: &Refitted, entry: usize) -> f64 {
    found.hypothesis.entries[entry].values[0]
}

fn vague(recording: &Recording) -> Error {
    Error::Usage(format!("{}: a machine like the one found so far cannot be followed along it", recording.name))
}

fn problem(before: &Config, steady: &Steady, (inertia, delay_s): (f64, f64), recordings: &[&Recording]) -> Problem {
    // All delays are fitted from the sample on.
    let machine = nominal(before, steady, inertia, delay_s, 0.0);
    let names: Vec<&str> = recordings.iter().map(|recording| recording.name.as_str()).collect();
    let recorded: Vec<Recorded> = recordings.iter().copied().map(Recorded::new).collect();
    let fitted = recorded.len();
    Problem::new(Physics::nominal(&machine, &names), recorded, fitted, machine.axis.resolution, false)
}

fn hypothesis(recording: &Recording, effects: &[(&'static str, Vec<f64>)]) -> Result<Hypothesis, Error> {
    let entry = |(id, values): &(&'static str, Vec<f64>)| Some(Entry { effect: find(id)?, values: values.clone() });
    let entries: Option<Vec<Entry>> = effects.iter().map(entry).collect();
    entries.map(|entries| Hypothesis { entries }).ok_or_else(|| vague(recording))
}

fn fitted(problem: &Problem, start: &Hypothesis, rounds: usize) -> Option<Refitted> {
    refit(problem, start, &first_noise(problem), rounds)
}
