//! A log: what of it would spoil a diagnosis.

use std::path::Path;

use super::{Check, State};
use crate::Error;
use crate::first_model::{FirstModel, first_model};
use crate::precheck::windows::median_period_s;
use crate::precheck::{SLOWEST_SAMPLING_S, is_too_slow};
use crate::read::{Axis, AxisKind, Given, Machine, Mapping, Recording, Table, guess, position_step};
use crate::report::Units;

/// Steps of time further from the median than this share of it make windows uneven; the model follows them all the same.
const JITTER: f64 = 0.2;
/// Rows at the very top of the effort, as a share, that are a limit and no peak.
const AT_LIMIT: f64 = 0.01;
/// Delays between effort and motion that are tried, in rows.
const MOST_DELAY_ROWS: usize = 40;
/// A shift of the effort must explain this share of what is left without it.
const DELAY_EXPLAINS: f64 = 0.1;
/// A position step this many times smaller than the travel is fine enough to see anything.
const STEPS_OF_TRAVEL: f64 = 50.0;

/// What is to be known of a log.
///
/// # Errors
/// A log that cannot be read as a recording.
pub(super) fn checks(file: &Path, machine: Option<&Machine>, given: Given<'_>) -> Result<Vec<Check>, Error> {
    let recording = read(file, machine, given)?;
    if recording.rows() < 2 {
        return Ok(vec![Check::new(State::Bad, "rate", "one row tells nothing; record longer".to_owned())]);
    }
    let period_s = median_period_s(&recording.t_s);
    let resolution = position_step(&recording.position).unwrap_or(0.0);
    let axis = Axis { kind: recording.axis, sample_period_s: period_s.clamp(1e-9, 1.0), resolution };
    let mut checks = vec![rate(&recording, period_s), jitter(&recording, period_s), gaps(&recording)];
    checks.push(steps(&recording, resolution));
    checks.push(saturation(&recording));
    let model = first_model(&axis, std::slice::from_ref(&recording));
    checks.push(balance(model.as_ref(), recording.axis));
    checks.extend(model.map(|model| skew(&recording, &axis, &model, period_s)));
    Ok(checks)
}

fn read(file: &Path, machine: Option<&Machine>, given: Given<'_>) -> Result<Recording, Error> {
    if let Some(machine) = machine {
        return Recording::of(file, machine);
    }
    let failed = |message: String| Error::input(file, None, "", message);
    let (axis, guesses) = guess(&Table::read(file)?, given).map_err(failed)?;
    let mapping = Mapping::new(guesses.into_iter().map(|guess| guess.mapped).collect(), axis).map_err(failed)?;
    Recording::mapped(file, axis, &mapping)
}

fn rate(recording: &Recording, period_s: f64) -> Check {
    let length_s = recording.t_s.last().unwrap_or(&0.0) - recording.t_s.first().unwrap_or(&0.0);
    let found = format!("{:.1} Hz, {} rows, {length_s:.2} s", 1.0 / period_s, recording.rows());
    if is_too_slow(period_s) || period_s <= 0.0 {
        let least_hz = 1.0 / SLOWEST_SAMPLING_S;
        let message = format!("{found}; too slow for any window of a motion: log at {least_hz:.0} Hz or more");
        return Check::new(State::Bad, "rate", message);
    }
    Check::new(State::Good, "rate", found)
}

fn jitter(recording: &Recording, period_s: f64) -> Check {
    let mut away: Vec<f64> =
        recording.t_s.windows(2).map(|pair| (pair[1] - pair[0] - period_s).abs() / period_s).collect();
    away.sort_by(f64::total_cmp);
    let at = |share: f64| away.get((share * away.len() as f64) as usize).or(away.last()).copied().unwrap_or(0.0);
    let found = format!("{:.1} % in nine steps of ten, {:.0} % at most", 100.0 * at(0.9), 100.0 * at(1.0));
    let state = if at(0.9) > JITTER { State::Note } else { State::Good };
    let hint = if state == State::Note { "; time stamps of the drive are better than those of the host" } else { "" };
    Check::new(state, "jitter", found + hint)
}

fn gaps(recording: &Recording) -> Check {
    match recording.gaps.first() {
        None => Check::new(State::Good, "gaps", "none"),
        Some(first) => {
            let (count, at_s) = (recording.gaps.len(), recording.t_s[*first]);
            Check::new(State::Note, "gaps", format!("rows are missing in {count} places, the first after {at_s:.4} s"))
        }
    }
}

fn travel(recording: &Recording) -> f64 {
    let (low, high) = range(&recording.position);
    high - low
}

fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}

fn steps(recording: &Recording, resolution: f64) -> Check {
    let (travel, unit) = (travel(recording), Units::of(recording.axis).position);
    if resolution == 0.0 {
        return Check::new(State::Good, "position", format!("travels {travel:.4} {unit}; no steps are seen"));
    }
    let found = format!("travels {travel:.4} {unit} in steps of {resolution:.3e} {unit}");
    if travel < STEPS_OF_TRAVEL * resolution {
        return Check::new(State::Bad, "position", format!("{found}: too few; move further"));
    }
    Check::new(State::Good, "position", found)
}

fn saturation(recording: &Recording) -> Check {
    let units = Units::of(recording.axis);
    let (low, high) = range(&recording.effort_cmd);
    if high - low <= 1e-9 * high.abs().max(low.abs()) {
        return Check::new(State::Bad, "saturation", format!("the {} is the same in every row", units.effort_name));
    }
    let share = |limit: f64| {
        let at = recording.effort_cmd.iter().filter(|effort| (**effort - limit).abs() <= 1e-6 * (high - low)).count();
        at as f64 / recording.rows() as f64
    };
    let (at_high, at_low) = (share(high), share(low));
    let found = format!("{} from {low:.4} to {high:.4} {}", units.effort_name, units.effort);
    // Zero is where a drive rests, not a limit.
    let limited = (at_high > AT_LIMIT && high != 0.0) || (at_low > AT_LIMIT && low != 0.0);
    if limited {
        let percent = 100.0 * at_high.max(at_low);
        let message = format!("{found}; {percent:.1} % of the rows at the very end: a limit? then state torque_limit");
        return Check::new(State::Note, "saturation", message);
    }
    Check::new(State::Good, "saturation", found)
}

fn balance(model: Option<&FirstModel>, axis: AxisKind) -> Check {
    let unit = if axis == AxisKind::Rotary { "kg m2" } else { "kg" };
    let Some(model) = model else {
        return Check::new(State::Bad, "excitation", "nothing moves enough to tell anything: make steps or a sweep");
    };
    let percent = 100.0 * model.explained;
    if model.reversed {
        let message = "torque or force pushes against the acceleration: a sign is wrong; give *-1 in --map";
        return Check::new(State::Bad, "excitation", message);
    }
    if !model.inertia.is_known() {
        let message = format!("friction shows, inertia does not (balance explains {percent:.0} %): accelerate more");
        return Check::new(State::Note, "excitation", message);
    }
    let known = format!(
        "inertia {:.3e} {unit} within {:.1e}; balance explains {percent:.0} %",
        model.inertia.value, model.inertia.within
    );
    Check::new(State::Good, "excitation", known)
}

/// Whether the effort fits the motion better at another time: a delay of the drive, or clocks that differ.
fn skew(recording: &Recording, axis: &Axis, model: &FirstModel, period_s: f64) -> Check {
    let left = |rows: usize| {
        let shifted = shifted(recording, rows);
        first_model(axis, std::slice::from_ref(&shifted)).map_or(1.0, |model| 1.0 - model.explained)
    };
    let most = MOST_DELAY_ROWS.min(recording.rows() / 10);
    let here = 1.0 - model.explained;
    let tried = [1, 2, 3, 5, 7, 10, 14, 20, 28, 40].into_iter().filter(|rows| *rows <= most);
    let best = tried.map(|rows| (rows, left(rows))).min_by(|one, other| one.1.total_cmp(&other.1));
    match best {
        Some((rows, left)) if left < (1.0 - DELAY_EXPLAINS) * here => {
            let message = format!(
                "the motion answers {:.1} ms after the effort: state torque_delay_s, or the clocks differ",
                1e3 * rows as f64 * period_s
            );
            Check::new(State::Note, "skew", message)
        }
        _ => Check::new(State::Good, "skew", "effort and motion go together"),
    }
}

/// The effort some rows later.
fn shifted(recording: &Recording, rows: usize) -> Recording {
    let mut shifted = recording.clone();
    shifted.effort_cmd.rotate_right(rows);
    let first = recording.effort_cmd[0];
    shifted.effort_cmd[..rows].fill(first);
    shifted
}
