//! A shift in time between effort and motion: a delay of the drive, or a column that is late.

use rayon::prelude::*;

use super::{Check, State};
use crate::first_model::{FirstModel, first_model, first_model_of};
use crate::read::{Axis, Machine, Recording};
use crate::report::Units;

/// Shifts that are tried go so far either way, s: as long as a drive or a bus can take.
const MOST_S: f64 = 0.05;
/// and over this share of the rows: what is moved in at the end is no measurement.
const MOST_OF_ROWS: usize = 10;
/// A shift of the effort must take away this share of what is left without it: friction that turns slowly, an arm that
/// bends or a balance that holds badly anyway take some away at any shift.
const EXPLAINS: f64 = 0.5;
/// Fewer windows tell no shift: half of what is left goes by chance in one of a thousand with 30.
const WINDOWS: usize = 30;

/// How effort and motion stand to each other in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Skew {
    /// The balance does not tell.
    Untold,
    Together,
    /// The effort fits the motion far better if it acts so many rows later, or earlier where they are below 0; the share that is less
    /// of what is left then.
    Rows(isize, f64),
}

impl Skew {
    /// By how many rows the effort is late.
    pub(super) fn late_rows(self) -> Option<isize> {
        match self {
            Self::Rows(rows, _) if rows < 0 => Some(-rows),
            _ => None,
        }
    }

    /// The delay that a model of the drive can have, s: an effort that comes after its motion is none.
    pub(super) fn delay_s(self, period_s: f64) -> f64 {
        match self {
            Self::Rows(rows, _) if rows > 0 => rows as f64 * period_s,
            _ => 0.0,
        }
    }

    /// What is said of it; `machine` where its file may state the delay.
    pub(super) fn check(self, recording: &Recording, machine: Option<&Machine>, period_s: f64) -> Check {
        let effort = Units::of(recording.axis).effort_name;
        let (rows, share) = match self {
            Self::Untold => {
                let message = format!("the balance does not tell whether {effort} and motion go together");
                return Check::new(State::Note, "skew", message);
            }
            Self::Together => return Check::new(State::Good, "skew", format!("{effort} and motion go together")),
            Self::Rows(rows, share) => (rows, 100.0 * share),
        };
        let (by, late_s) = (time(rows.unsigned_abs(), period_s), rows as f64 * period_s);
        let stated = machine.map(|machine| machine.plant.sample_to_output_s + machine.plant.torque_delay_s);
        if stated.is_some_and(|stated_s| (stated_s - late_s).abs() < 2.0 * period_s) {
            let message = format!("the position is about {by} behind the {effort}, as the machine file says");
            return Check::new(State::Good, "skew", message);
        }
        let message = if rows > 0 {
            format!(
                "the position is about {by} behind the {effort}: so much later {share:.0} % less of the balance is left: state torque_delay_s \
                 if the drive is so slow; if not, the column of the position is late"
            )
        } else {
            format!(
                "the column of the {effort} is about {by} late: so much earlier {share:.0} % less of the balance is left: was it measured \
                 over a bus? log the command, or move the column up by {} rows",
                rows.unsigned_abs()
            )
        };
        Check::new(State::Note, "skew", message)
    }
}

/// A time of whole rows with no more digits than a row has, and in rows.
fn time(rows: usize, period_s: f64) -> String {
    let digits = (-(1e3 * period_s).log10()).ceil().clamp(0.0, 3.0) as usize;
    format!("{:.digits$} ms ({rows} row{})", 1e3 * rows as f64 * period_s, if rows == 1 { "" } else { "s" })
}

/// Where the effort fits the motion best: about where the motion tells the inertia best, in windows of whatever length, and then to a
/// row in windows of that length. Those that suit the log as it is are long where it is far off, and blur it.
pub(super) fn skew(recording: &Recording, axis: &Axis, model: &FirstModel, period_s: f64) -> Skew {
    let most = ((MOST_S / period_s) as usize).min(recording.rows() / MOST_OF_ROWS).cast_signed();
    let about = coarse(most).into_par_iter().filter_map(|rows| {
        let model = first_model(axis, &[shifted(recording, rows)]).filter(trusted)?;
        Some((rows, model.inertia.within / model.inertia.value, model.windows))
    });
    let about = about.min_by(|one, other| one.1.total_cmp(&other.1));
    let Some((about, _, (_, length_s))) = about.filter(|(.., windows)| windows.0 >= WINDOWS) else {
        return Skew::Untold;
    };
    let of = |rows: isize| first_model_of(axis, &[shifted(recording, rows)], length_s);
    let (best, left) = refined(about, most, |rows| of(rows).filter(trusted).map_or(f64::INFINITY, |model| model.left));
    let still = of(0).map_or(f64::INFINITY, |model| model.left);
    // What is best at the longest shift of all has no best one.
    let is_a_best = best.abs() < most || most == 1;
    if left < (1.0 - EXPLAINS) * still && is_a_best {
        return Skew::Rows(best, 1.0 - (left / still).sqrt());
    }
    if trusted(model) { Skew::Together } else { Skew::Untold }
}

/// The shift near this one that leaves least, and what it leaves; as far as to the next coarse ones.
fn refined(about: isize, most: isize, left: impl Fn(isize) -> f64) -> (isize, f64) {
    let mut best = (about, left(about));
    let mut step = (about.abs() + 1) / 4;
    while step > 0 {
        for rows in [best.0 - step, best.0 + step].into_iter().filter(|rows| rows.abs() <= most) {
            let left = left(rows);
            best = if left < best.1 { (rows, left) } else { best };
        }
        step /= 2;
    }
    best
}

/// Whether the balance has an inertia and explains enough.
fn trusted(model: &FirstModel) -> bool {
    let has_inertia = model.inertia.is_known() && model.inertia.value > 0.0 && !model.reversed;
    has_inertia && model.is_trusted()
}

/// Shifts either way, rows: each to 16, and then some eighth more than the one before. One row aside blurs what is sharp.
fn coarse(most: isize) -> Vec<isize> {
    let mut shifts = Vec::new();
    let mut rows = 1;
    while rows <= most {
        shifts.extend([rows, -rows]);
        rows = (rows + 1).max(rows * 9 / 8);
    }
    shifts
}

/// The effort some rows later; earlier where they are below 0. What is moved in is the value at that end.
pub(super) fn shifted(recording: &Recording, rows: isize) -> Recording {
    let effort = &recording.effort_cmd;
    let last = effort.len().saturating_sub(1);
    let moved = (0..effort.len()).map(|row| effort[row.saturating_add_signed(-rows).min(last)]).collect();
    Recording { effort_cmd: moved, ..recording.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifts_are_tried_either_way_and_told_with_the_digits_of_a_row() {
        assert_eq!(coarse(3), [1, -1, 2, -2, 3, -3]);
        assert!(coarse(40).ends_with(&[33, -33, 37, -37]), "{:?}", coarse(40));
        assert!(coarse(0).is_empty());
        assert_eq!(time(6, 0.002), "12 ms (6 rows)");
        assert_eq!(time(13, 0.0005), "6.5 ms (13 rows)");
        assert_eq!(time(1, 0.0125), "12 ms (1 row)");
    }
}
