//! A log: what of it would spoil a diagnosis.

use std::path::Path;

use super::shows::shows;
use super::{Check, State};
use crate::Error;
use crate::cli::effort_units::EffortUnits;
use crate::cli::velocity_check::{WrongVelocity, wrong_velocity};
use crate::first_model::{FirstModel, first_model, first_model_of};
use crate::precheck::windows::median_period_s;
use crate::precheck::wrong_rate;
use crate::read::{Axis, Column, Given, Machine, Mapping, Recording, Table, guess, position_step, wrap};
use crate::report::Units;

/// Steps of time further from the median than this share of it make windows uneven; the model follows them all the same.
const JITTER: f64 = 0.2;
/// Rows at the very top of the effort, as a share, that are a limit and no peak.
const AT_LIMIT: f64 = 0.01;
/// Delays between effort and motion that are tried, in rows.
const MOST_DELAY_ROWS: usize = 40;
/// and as long as a drive or a bus can take, s.
const MOST_DELAY_S: f64 = 0.05;
/// A shift of the effort must take away this share of what is left without it: friction that turns slowly, an arm that
/// bends or a balance that holds badly anyway take some away at any shift.
const DELAY_EXPLAINS: f64 = 0.5;
/// Fewer windows tell no delay: half of what is left goes by chance in one of a thousand with 30.
const DELAY_WINDOWS: usize = 30;
/// An explained share of the effort below which nothing of the balance is to be trusted.
const EXPLAINED_ENOUGH: f64 = 0.5;
/// An effort of so few values is a test signal, and its ends are no limit.
const LEVELS: usize = 10;
/// A position step this many times smaller than the travel is fine enough to see anything.
const STEPS_OF_TRAVEL: f64 = 50.0;

/// What is to be known of a log.
///
/// # Errors
/// A log that cannot be read as a recording.
pub(super) fn checks(file: &Path, machine: Option<&Machine>, given: Given<'_>) -> Result<Vec<Check>, Error> {
    let (mut recording, mapping) = read(file, machine, given)?;
    if recording.rows() < 2 {
        return Ok(vec![Check::new(State::Bad, "rate", "one row tells nothing; record longer".to_owned())]);
    }
    let period_s = median_period_s(&recording.t_s);
    let units = EffortUnits::of(recording.axis, &mapping);
    let wrapped = wrapped(&mut recording, &mapping);
    let resolution = position_step(&recording.position).unwrap_or(0.0);
    let axis = Axis { kind: recording.axis, sample_period_s: period_s.clamp(1e-9, 1.0), resolution };
    let mut checks = vec![rate(&recording, period_s), jitter(&recording, period_s), gaps(&recording)];
    checks.push(steps(&recording, resolution));
    checks.extend(wrapped);
    checks.extend(wrong_velocity(&recording).map(velocity));
    checks.push(saturation(&recording, &units));
    let model = first_model(&axis, std::slice::from_ref(&recording));
    checks.push(balance(model.as_ref(), &units));
    let delay = model.as_ref().and_then(|model| delay(&recording, &axis, model, period_s));
    checks.extend(model.is_some().then(|| skew(delay)));
    let first = model.as_ref().map(|model| (model, delay.map_or(0.0, |(delay_s, _)| delay_s)));
    checks.extend(shows(&recording, &axis, machine, first));
    Ok(checks)
}

fn velocity(wrong: WrongVelocity) -> Check {
    let state = if wrong == WrongVelocity::Unlike { State::Note } else { State::Bad };
    Check::new(state, "velocity", wrong.to_string())
}

/// Whether the position wraps; if so it counts on afterwards, for the other checks.
fn wrapped(recording: &mut Recording, mapping: &Mapping) -> Option<Check> {
    let wrap = wrap(&recording.position)?;
    let mapped = mapping.columns().iter().find(|mapped| mapped.column == Column::Position);
    let width = wrap.width_in(mapped.map_or(1.0, |mapped| mapped.factor()));
    let unit = mapped.map_or(Units::of(recording.axis).position, |mapped| mapped.unit.as_str());
    let (count, row) = (wrap.rows.len(), wrap.rows.first().map_or(0, |row| row + 1));
    wrap.undo(&mut recording.position);
    let found = format!(
        "it jumps by {width:?} {unit} in {count} places, the first after row {row}: the drive keeps it within a range; put \
         `wrap = {width:?}` beside `position` in [columns] of the machine file, as init does"
    );
    Some(Check::new(State::Bad, "wrap", found))
}

fn read(file: &Path, machine: Option<&Machine>, given: Given<'_>) -> Result<(Recording, Mapping), Error> {
    if let Some(machine) = machine {
        return Ok((Recording::of(file, machine)?, machine.columns.clone()));
    }
    let failed = |message: String| Error::input(file, None, "", message);
    let (axis, guesses) = guess(&Table::read(file)?, given).map_err(failed)?;
    let mapping = Mapping::new(guesses.into_iter().map(|guess| guess.mapped).collect(), axis).map_err(failed)?;
    Ok((Recording::mapped(file, axis, &mapping)?, mapping))
}

fn rate(recording: &Recording, period_s: f64) -> Check {
    let length_s = recording.t_s.last().unwrap_or(&0.0) - recording.t_s.first().unwrap_or(&0.0);
    let found = format!("{:.1} Hz, {} rows, {length_s:.2} s", 1.0 / period_s, recording.rows());
    if let Some(wrong) = wrong_rate(period_s) {
        return Check::new(State::Bad, "rate", format!("{found}; {wrong}"));
    }
    Check::new(State::Good, "rate", found)
}

fn jitter(recording: &Recording, period_s: f64) -> Check {
    let mut away: Vec<f64> =
        recording.t_s.windows(2).map(|pair| (pair[1] - pair[0] - period_s).abs() / period_s).collect();
    away.sort_by(f64::total_cmp);
    let at = |share: f64| away.get((share * away.len() as f64) as usize).or(away.last()).copied().unwrap_or(0.0);
    let steps = recording.t_s.windows(2).map(|pair| (pair[1] - pair[0] - period_s).abs());
    let worst = steps.enumerate().max_by(|one, other| one.1.total_cmp(&other.1)).map_or(0, |(row, _)| row + 1);
    let found =
        format!("{:.1} % in nine steps of ten, {:.0} % at most, after row {worst}", 100.0 * at(0.9), 100.0 * at(1.0));
    let state = if at(0.9) > JITTER { State::Note } else { State::Good };
    let hint = if state == State::Note { "; time stamps of the drive are better than those of the host" } else { "" };
    Check::new(state, "jitter", found + hint)
}

fn gaps(recording: &Recording) -> Check {
    match recording.gaps.first() {
        None => Check::new(State::Good, "gaps", "none"),
        Some(first) => {
            let (count, at_s) = (recording.gaps.len(), recording.t_s[*first] - recording.t_s[0]);
            let found = format!(
                "rows are missing in {count} places, the first after row {}, {at_s:.3} s after the start",
                first + 1
            );
            Check::new(State::Note, "gaps", found)
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

fn saturation(recording: &Recording, effort: &EffortUnits) -> Check {
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
    let found = format!("{} from {low:.4} to {high:.4} {}", units.effort_name, effort.effort);
    let levels = levels(&recording.effort_cmd, 1e-6 * (high - low));
    if levels <= LEVELS {
        return Check::new(State::Good, "saturation", format!("{found}, a test signal of {levels} levels"));
    }
    // Zero is where a drive rests, not a limit.
    let limited = (at_high > AT_LIMIT && high != 0.0) || (at_low > AT_LIMIT && low != 0.0);
    if limited {
        let percent = 100.0 * at_high.max(at_low);
        let message = format!("{found}; {percent:.1} % of the rows at the very end: a limit? then state torque_limit");
        return Check::new(State::Note, "saturation", message);
    }
    Check::new(State::Good, "saturation", found)
}

/// How many values there are, those within `alike` of each other counted once; at most one more than are of a test signal.
fn levels(values: &[f64], alike: f64) -> usize {
    let mut levels: Vec<f64> = Vec::new();
    for value in values {
        if !levels.iter().any(|level| (level - value).abs() <= alike) {
            levels.push(*value);
        }
        if levels.len() > LEVELS {
            break;
        }
    }
    levels.len()
}

fn balance(model: Option<&FirstModel>, units: &EffortUnits) -> Check {
    let note = |message: String| Check::new(State::Note, "excitation", message);
    let Some(model) = model else {
        return Check::new(State::Bad, "excitation", "nothing moves enough to tell anything: make steps or a sweep");
    };
    if model.reversed {
        let message = "torque or force pushes against the acceleration: a sign is wrong; give *-1 in --map";
        return Check::new(State::Bad, "excitation", message);
    }
    let percent = 100.0 * model.explained;
    let one_way = if model.one_way {
        "; motion in one direction only: friction and an offset cannot be told apart, move both ways"
    } else {
        ""
    };
    if model.explained < EXPLAINED_ENOUGH {
        let message =
            "of the effort are explained by inertia, friction, offset and gravity: no value of them is to be trusted";
        return note(format!("{percent:.0} % {message}{one_way}"));
    }
    if !model.inertia.is_known() || model.inertia.value < 0.0 {
        let message =
            format!("the motion does not tell the inertia (balance explains {percent:.0} %): accelerate more");
        return note(message + one_way);
    }
    let inertia = (model.inertia.value, &units.inertia, model.inertia.within);
    let found = format!(
        "inertia {:.3e} {} within {:.1e}; balance explains {percent:.0} %{one_way}",
        inertia.0, inertia.1, inertia.2
    );
    let state = if model.one_way { State::Note } else { State::Good };
    Check::new(state, "excitation", found)
}

fn skew(delay: Option<(f64, f64)>) -> Check {
    let Some((delay_s, share)) = delay else {
        return Check::new(State::Good, "skew", "effort and motion go together");
    };
    let message = format!(
        "with the effort {:.1} ms later {:.0} % less of the balance is left: state torque_delay_s, or the clocks differ",
        1e3 * delay_s,
        100.0 * share
    );
    Check::new(State::Note, "skew", message)
}

/// The time, s, by which the effort fits the motion far better if it acts later, and the share that is less of what is left then: a
/// delay of the drive, or clocks that differ; none where it fits as it is.
fn delay(recording: &Recording, axis: &Axis, model: &FirstModel, period_s: f64) -> Option<(f64, f64)> {
    let (windows, length_s) = model.windows;
    let trusted = |model: &FirstModel| model.inertia.is_known() && model.inertia.value > 0.0 && !model.reversed;
    if !trusted(model) || model.explained < EXPLAINED_ENOUGH || windows < DELAY_WINDOWS {
        return None;
    }
    let left = |rows: usize| {
        let shifted = first_model_of(axis, &[shifted(recording, rows)], length_s).filter(trusted);
        shifted.map_or(f64::INFINITY, |model| model.left)
    };
    let most = MOST_DELAY_ROWS.min(recording.rows() / 10).min((MOST_DELAY_S / period_s) as usize);
    let tried: Vec<usize> = [1, 2, 3, 5, 7, 10, 14, 20, 28, 40].into_iter().filter(|rows| *rows <= most).collect();
    let best = tried.iter().map(|rows| (*rows, left(*rows))).min_by(|one, other| one.1.total_cmp(&other.1));
    let (rows, left) = best?;
    // What is best at the longest shift of all has no best one.
    let is_a_best = tried.len() == 1 || tried.last() != Some(&rows);
    let explains = left < (1.0 - DELAY_EXPLAINS) * model.left && is_a_best;
    explains.then(|| (rows as f64 * period_s, 1.0 - (left / model.left).sqrt()))
}

/// The effort some rows later.
fn shifted(recording: &Recording, rows: usize) -> Recording {
    let mut shifted = recording.clone();
    shifted.effort_cmd.rotate_right(rows);
    let first = recording.effort_cmd[0];
    shifted.effort_cmd[..rows].fill(first);
    shifted
}
