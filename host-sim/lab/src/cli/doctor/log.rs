//! A log: what of it would spoil a diagnosis.

use std::path::Path;

use super::motion::motion;
use super::shows::shows;
use super::skew::{shifted, skew};
use super::{Check, State};
use crate::Error;
use crate::cli::effort_units::EffortUnits;
use crate::cli::velocity_check::{WrongVelocity, wrong_velocity};
use crate::first_model::{FirstModel, first_model};
use crate::precheck::windows::median_period_s;
use crate::precheck::{Purpose, range, travel, wrong_rate};
use crate::read::{
    Axis, Column, Given, Machine, Mapping, Recording, Table, guess, places, position_step, wrap, wrong_samples,
};
use crate::report::Units;

/// Steps of time further from the median than this share of it make windows uneven; the model follows them all the same.
const JITTER: f64 = 0.2;
/// Rows at the very top of the effort, as a share, that are a limit and no peak.
const AT_LIMIT: f64 = 0.01;
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
    checks.extend(recording.mended.iter().map(|mended| Check::new(State::Note, "rows", mended.clone())));
    checks.push(steps(&recording, resolution));
    checks.push(motion(&recording, &axis, period_s));
    checks.extend(apart(&recording, resolution));
    checks.extend(wrapped);
    checks.extend(wrong_velocity(&recording).map(velocity));
    checks.push(saturation(&recording, &units));
    // What no diagnosis takes shows nothing, however it moves.
    if checks[0].state == State::Bad {
        return Ok(checks);
    }
    let Some(mut model) = first_model(&axis, std::slice::from_ref(&recording)) else {
        checks.push(balance(None, &units));
        checks.extend(shows(&recording, &axis, machine, None));
        return Ok(checks);
    };
    let skew = skew(&recording, &axis, &model, period_s);
    let told = skew.check(&recording, machine, period_s);
    // A model can act late, not early: an effort that is late is moved to where it belongs.
    let moved = skew.late_rows().map(|rows| shifted(&recording, -rows));
    model = moved.as_ref().and_then(|moved| first_model(&axis, std::slice::from_ref(moved))).unwrap_or(model);
    checks.extend([balance(Some(&model), &units), told]);
    // What a machine file is given for is looked at as it is.
    let seen = moved.as_ref().filter(|_| machine.is_none()).unwrap_or(&recording);
    checks.extend(shows(seen, &axis, machine, Some((&model, skew.delay_s(period_s)))));
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
        "it jumps by {width:?} {unit} in {}, the first after row {row}: the drive keeps it within a range; put \
         `wrap = {width:?}` beside `position` in [columns] of the machine file, as init does",
        places(count)
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
    let needed_s = Purpose::Diagnose.needed_s(period_s);
    if length_s < needed_s {
        let found = format!("{found}; too short: diagnose needs {needed_s:.1} s, of all its recordings together");
        return Check::new(State::Bad, "rate", found);
    }
    Check::new(State::Good, "rate", found)
}

/// How uneven the steps of time are, but those over rows that are missing.
fn jitter(recording: &Recording, period_s: f64) -> Check {
    let steps = recording.t_s.windows(2).enumerate().filter(|(row, _)| recording.gaps.binary_search(row).is_err());
    let mut away: Vec<(f64, usize)> =
        steps.map(|(row, pair)| ((pair[1] - pair[0] - period_s).abs() / period_s, row + 1)).collect();
    away.sort_by(|one, other| one.0.total_cmp(&other.0));
    let Some(&(worst, row)) = away.last() else {
        return Check::new(State::Note, "jitter", "rows are missing after each that is there");
    };
    let nine_of_ten = away.get((0.9 * away.len() as f64) as usize).map_or(worst, |step| step.0);
    let found =
        format!("{:.1} % in nine steps of ten, {:.0} % at most, after row {row}", 100.0 * nine_of_ten, 100.0 * worst);
    let state = if nine_of_ten > JITTER { State::Note } else { State::Good };
    let hint = if state == State::Note { "; time stamps of the drive are better than those of the host" } else { "" };
    Check::new(state, "jitter", found + hint)
}

fn gaps(recording: &Recording) -> Check {
    match recording.gaps.first() {
        None => Check::new(State::Good, "gaps", "none"),
        Some(first) => {
            let (count, at_s) = (recording.gaps.len(), recording.t_s[*first] - recording.t_s[0]);
            let found = format!(
                "rows are missing in {}, the first after row {}, {at_s:.3} s after the start",
                places(count),
                first + 1
            );
            Check::new(State::Note, "gaps", found)
        }
    }
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

/// Samples that no motion has.
fn apart(recording: &Recording, resolution: f64) -> Option<Check> {
    let wrong = wrong_samples(&recording.t_s, &recording.position, resolution);
    let (row, off) = wrong.first()?;
    let found = format!(
        "stand apart from both neighbours in {}, the first in row {} by {off:.2e} {}: leave those rows out, for rows that are \
         missing do no harm",
        places(wrong.len()),
        row + 1,
        Units::of(recording.axis).position
    );
    Some(Check::new(State::Bad, "samples", found))
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
    if !model.is_trusted() {
        let message = "of the effort are explained by inertia, friction, offset and gravity or a spring: no value of them is to be trusted";
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
