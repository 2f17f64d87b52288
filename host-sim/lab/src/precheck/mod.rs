//! What is wrong with the data before any science: findings about recordings and the machine file they are read with.
//!
//! Pure: it reads no file and prints nothing. Each finding is a sentence; an error means that nothing can be computed, a
//! warning that what is computed may mean something else than it seems.

mod finding;
mod inertia;
pub(crate) mod windows;

pub use finding::{Finding, Problem, Severity};

use std::path::Path;

use diagnosis::recorded::ACTS_S;

use crate::Error;
use crate::read::{AxisKind, Column, Machine, Recording, position_step, wrong_samples};
use crate::residual::spread_at_rest;
use inertia::{Estimate, Inertia, estimate};
use windows::median_period_s;

/// What the data is wanted for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Windows of the model beside the recording.
    Compare,
    /// A search for what the model leaves out, judged on blocks that were not fitted.
    Diagnose,
}

impl Purpose {
    /// The least that can be worked on, s, of rows a period apart: the longest window of a comparison, a block to fit and one
    /// to judge by (0.4 s each) of a diagnosis; and rows enough for one window, or for five windows of eight.
    pub(crate) fn needed_s(self, period_s: f64) -> f64 {
        match self {
            Self::Compare => (10.0 * period_s).max(0.2),
            Self::Diagnose => (40.0 * period_s).max(0.8),
        }
    }
}

/// Rows further apart than this hold no window of a motion, s.
const SLOWEST_SAMPLING_S: f64 = 0.05;

/// Whether rows are too far apart; a time that only its decimal digits put beyond the limit is not.
fn is_too_slow(period_s: f64) -> bool {
    period_s > SLOWEST_SAMPLING_S * (1.0 + 1e-6)
}

/// Rows further apart than this are rather of another unit than of a slow log, s: ten times what is of use.
const OTHER_UNIT_S: f64 = 0.5;
/// Rows nearer together than this are of no drive's log, s: 100 kHz is the current loop of the fastest.
const FASTEST_SAMPLING_S: f64 = 1e-5;

/// What is wrong with rows that are a median of `period_s` apart, and what to do; none where they will do.
pub(crate) fn wrong_rate(period_s: f64) -> Option<String> {
    let unit = "is the time in another unit? --map \"time=NAME:ms\" or `[columns]` tells it";
    if 0.0 < period_s && period_s < FASTEST_SAMPLING_S {
        return Some(format!("faster than any drive logs: {unit}"));
    }
    let wrong = is_too_slow(period_s) || period_s <= 0.0;
    let least_hz = 1.0 / SLOWEST_SAMPLING_S;
    let or = if period_s > OTHER_UNIT_S { format!("; {unit}") } else { String::new() };
    wrong.then(|| format!("too slow for any window of a motion: log at {least_hz:.0} Hz or more{or}"))
}

/// Largest value of a column in its unit: doubles hold whole numbers up to 9e15, and beyond no motion can be told from rounding.
const LARGEST: f64 = 1e15;
/// A period this many times another is of another unit; decimation and a slower log are not.
const OTHER_UNIT: f64 = 100.0;
/// A step or an inertia this many times another is not the same one measured badly.
const FAR_OFF: f64 = 5.0;
/// Partial correlation of torque and acceleration below which one of them has the wrong sign for certain: a machine of any
/// inertia has a positive one.
const SIGN_CERTAIN: f64 = -0.9;

/// Speeds and accelerations beyond which no servo axis goes, and travels beyond which none measures, in the units of the axis.
#[derive(Debug, Clone, Copy)]
struct Limits {
    /// rad/s: 95,000 rpm, of the fastest spindles; m/s: ten times a fast linear motor.
    speed: f64,
    /// rad/s2: a galvanometer, ten times over; m/s2: 1000 g, ten times a voice coil.
    acceleration: f64,
}

impl Limits {
    fn of(axis: AxisKind) -> Self {
        match axis {
            AxisKind::Rotary => Self { speed: 1e4, acceleration: 1e8 },
            AxisKind::Linear => Self { speed: 50.0, acceleration: 1e4 },
        }
    }
}

/// What is wrong with the recordings, those to fit first; `holdout` is empty for a comparison.
// Over 40 lines: each reason to look no further at a recording, in their order.
pub fn check(machine: &Machine, fitted: &[Recording], holdout: &[Recording], purpose: Purpose) -> Vec<Finding> {
    let stands = |recording: &Recording| travel(recording) <= still_within(machine, recording);
    let stand: Vec<bool> = fitted.iter().chain(holdout).map(stands).collect();
    let moves = stand[..fitted.len()].contains(&false);
    let length_s: f64 = fitted.iter().map(length_s).sum();
    let (mut findings, mut right_way) = (Vec::new(), false);
    for (index, recording) in fitted.iter().chain(holdout).enumerate() {
        let mut add = |problem, severity| {
            findings.push(Finding { recording: recording.name.clone(), axis: recording.axis, problem, severity });
        };
        let mut earlier = fitted.iter().chain(holdout).take(index);
        if purpose == Purpose::Diagnose && earlier.any(|other| has_same_rows(other, recording)) {
            add(Problem::SameRows, Severity::Error);
            continue;
        }
        if let Some(huge) = huge(recording) {
            add(huge, Severity::Error);
            continue;
        }
        let period_s = median_period_s(&recording.t_s);
        let needed_s = purpose.needed_s(period_s);
        let own_s = self::length_s(recording);
        if is_too_slow(period_s) && recording.rows() > 2 {
            let problem =
                Problem::SlowSampling { period_s, most_s: SLOWEST_SAMPLING_S, file_s: machine.axis.sample_period_s };
            add(problem, Severity::Error);
            continue;
        }
        if own_s < needed_s {
            // Short recordings add up where they are fitted together.
            let enough = purpose == Purpose::Diagnose && (index >= fitted.len() || length_s >= needed_s);
            let severity = if enough { Severity::Warning } else { Severity::Error };
            add(Problem::TooShort { length_s: own_s, needed_s, period_s }, severity);
            continue;
        }
        let left_s = judged_s(recording);
        if purpose == Purpose::Diagnose && left_s < needed_s {
            add(Problem::Gaps { gaps: recording.gaps.len(), left_s, needed_s }, Severity::Error);
            continue;
        }
        if stand[index] {
            let nothing = purpose == Purpose::Diagnose && !moves;
            add(
                Problem::NeverMoves { travel: travel(recording) },
                if nothing { Severity::Error } else { Severity::Warning },
            );
            continue;
        }
        right_way |=
            one(machine, recording, period_s, purpose, &mut add).is_some_and(|inertia| inertia.correlation > 0.0);
    }
    // One log has one wiring: where a recording has the right sign, other torques turned that of another one.
    let turned = findings.iter_mut().filter(|finding| matches!(finding.problem, Problem::SignFlipped { .. }));
    turned.filter(|_| right_way).for_each(|finding| finding.severity = Severity::Warning);
    findings
}

/// The warnings as sentences.
///
/// # Errors
/// [`Error::Input`] with the first finding that leaves nothing to compute.
pub fn warnings(
    machine: &Machine,
    fitted: &[Recording],
    holdout: &[Recording],
    purpose: Purpose,
) -> Result<Vec<String>, Error> {
    if machine.plant.er.as_ref().is_some_and(|er| er.fluid.is_some()) {
        let message =
            "is for `simulate` and `tune`; what follows a recording does not know these laws: leave the section out";
        return Err(Error::input(&machine.file, None, "plant.er.fluid", message));
    }
    let findings = check(machine, fitted, holdout, purpose);
    match findings.iter().find(|finding| finding.severity == Severity::Error) {
        Some(finding) => {
            let column = finding.column().unwrap_or_default();
            Err(Error::input(Path::new(&finding.recording), None, column, finding.problem_text()))
        }
        None => Ok(findings.iter().map(ToString::to_string).collect()),
    }
}

/// What is wrong with a recording that is long enough and moves; returns what it says of the inertia.
fn one(
    machine: &Machine,
    recording: &Recording,
    period_s: f64,
    purpose: Purpose,
    add: &mut dyn FnMut(Problem, Severity),
) -> Option<Inertia> {
    let (low, high) = range(&recording.effort_cmd);
    // Constant but for the rounding of a log.
    let constant = high - low <= 1e-9 * high.abs().max(low.abs());
    if constant {
        add(Problem::ConstantEffort { value: high }, Severity::Warning);
    }
    let estimate = estimate(machine, recording, period_s);
    let units = units(machine, recording, period_s, &estimate);
    units.iter().for_each(|problem| add(*problem, Severity::Warning));
    if !constant {
        // Gravity follows the sine of the position, in rad: with another unit it is not taken out, and tells no sign.
        let trusted = units.is_empty();
        balance(machine, &estimate, (purpose, trusted), add);
    }
    estimate.inertia
}

/// What looks like a wrong unit.
fn units(machine: &Machine, recording: &Recording, period_s: f64, estimate: &Estimate) -> Vec<Problem> {
    let (file_s, resolution) = (machine.axis.sample_period_s, machine.axis.resolution);
    let limits = Limits::of(recording.axis);
    let is_other_period = !(1.0 / OTHER_UNIT..OTHER_UNIT).contains(&(period_s / file_s));
    let is_far = |step: &f64| resolution > 0.0 && !(1.0 / FAR_OFF..=FAR_OFF).contains(&(step / resolution));
    let Estimate { speed, acceleration, .. } = *estimate;
    let step = position_step(&recording.position);
    let wrong = wrong_samples(&recording.t_s, &recording.position, step.unwrap_or(0.0));
    let problems = [
        wrong.first().map(|first| Problem::WrongSamples { count: wrong.len(), first: *first }),
        is_other_period.then_some(Problem::OtherPeriod { period_s, file_s }),
        step.filter(|step| is_far(step) && (*step > resolution || moves_by(*step, recording)))
            .map(|step| Problem::OtherStep { step, resolution }),
        (speed > limits.speed).then_some(Problem::Speed { value: speed, most: limits.speed }),
        (acceleration > limits.acceleration)
            .then_some(Problem::Acceleration { value: acceleration, most: limits.acceleration }),
    ];
    problems.into_iter().flatten().collect()
}

/// Steps in a row by which a sensor's own step shows. What lies on a finer lattice but moves by more of it at a time may be the
/// digits of the log.
const AT_ONCE: f64 = 20.0;

/// Whether a position moves by few steps of this size from row to row, mostly.
fn moves_by(step: f64, recording: &Recording) -> bool {
    let changes = || recording.position.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|change| *change > 0.0);
    2 * changes().filter(|change| *change < AT_ONCE * step).count() >= changes().count()
}

/// Whether torque and acceleration fit each other, where the units are trusted, and the inertia of the machine file.
fn balance(
    machine: &Machine,
    estimate: &Estimate,
    (purpose, trusted): (Purpose, bool),
    add: &mut dyn FnMut(Problem, Severity),
) {
    let Some(inertia) = estimate.inertia else { return };
    let nominal = machine.plant.inertia;
    let far_off = inertia.low > FAR_OFF * nominal || inertia.high < nominal / FAR_OFF;
    if inertia.correlation < 0.0 {
        if !trusted {
            return;
        }
        // A column that is turned round shows the machine's own inertia; another one is of friction or a fluid that goes with the motion.
        let certain = inertia.correlation < SIGN_CERTAIN && !far_off && purpose == Purpose::Diagnose;
        let severity = if certain { Severity::Error } else { Severity::Warning };
        add(Problem::SignFlipped { correlation: inertia.correlation }, severity);
    } else if far_off {
        add(Problem::Inertia { low: inertia.low, high: inertia.high, nominal }, Severity::Warning);
    }
}

/// The first column with a value that nothing can be computed from.
fn huge(recording: &Recording) -> Option<Problem> {
    let columns = [
        (Column::Position, Some(&recording.position)),
        (Column::EffortCmd, Some(&recording.effort_cmd)),
        (Column::FieldCmd, recording.field_cmd_kv_mm.as_ref()),
        (Column::Velocity, recording.velocity.as_ref()),
    ];
    let largest = |values: &Vec<f64>| values.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()));
    columns.into_iter().find_map(|(column, values)| {
        let value = values.and_then(largest).filter(|value| value.abs() > LARGEST)?;
        Some(Problem::Huge { column, value, most: LARGEST })
    })
}

fn has_same_rows(one: &Recording, other: &Recording) -> bool {
    one.t_s == other.t_s && one.position == other.position && one.effort_cmd == other.effort_cmd
}

fn length_s(recording: &Recording) -> f64 {
    recording.t_s.last().unwrap_or(&0.0) - recording.t_s.first().unwrap_or(&0.0)
}

/// Time in which a diagnosis takes residuals, s: without what follows each gap while lost commands still act.
fn judged_s(recording: &Recording) -> f64 {
    let t_s = &recording.t_s;
    let starts = std::iter::once(0).chain(recording.gaps.iter().map(|gap| gap + 1));
    let ends = recording.gaps.iter().copied().chain(std::iter::once(t_s.len().saturating_sub(1)));
    let piece = |(place, (start, end)): (usize, (usize, usize))| {
        let (Some(from_s), Some(to_s)) = (t_s.get(start), t_s.get(end)) else { return 0.0 };
        (to_s - from_s - if place == 0 { 0.0 } else { ACTS_S }).max(0.0)
    };
    starts.zip(ends).enumerate().map(piece).sum()
}

/// The least and the largest of some values.
pub(crate) fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}

/// How far the axis goes, rad (m).
pub(crate) fn travel(recording: &Recording) -> f64 {
    let (low, high) = range(&recording.position);
    high - low
}

/// A travel that is none, rad (m): steps and noise of the sensor, or rounding where it has neither.
fn still_within(machine: &Machine, recording: &Recording) -> f64 {
    let (low, high) = range(&recording.position);
    spread_at_rest(recording, &machine.axis, recording.rows()).max(1e-12 * low.abs().max(high.abs()))
}
