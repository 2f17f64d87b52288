//! Long recordings in stretches: a diagnosis goes a thousand times over what it looks at, so that is bounded.

use std::ops::Range;

use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

use diagnosis::likelihood::Grid;

use crate::precheck::windows::median_period_s;
use crate::read::Recording;

/// Substeps of all recordings that a diagnosis looks at, two minutes at 2 kHz: a thousand passes over them are half of what a
/// search may cost (`diagnosis::problem`).
const SUBSTEPS: usize = 240_000;
/// Length of a stretch, s: all that a motion shows from one standstill to the next.
const STRETCH_S: f64 = 5.0;
/// Of the places of the stretches.
const SEED: u64 = 1;

/// The recordings as they are diagnosed: whole, or where they have more rows than are looked at, stretches of them spread
/// evenly, each at a random place of its share of the time so that a periodic motion is not always met at the same place.
/// What is left out is told in `notes`.
pub(super) fn stretches(files: &[&Recording], notes: &mut Vec<String>) -> Vec<Recording> {
    let substeps: usize = files.iter().map(|file| Grid::substeps_over(&file.t_s, median_period_s(&file.t_s))).sum();
    if substeps <= SUBSTEPS {
        return files.iter().map(|file| file.driven(std::slice::from_ref(&(0..file.rows())))).collect();
    }
    let share = SUBSTEPS as f64 / substeps as f64;
    let rows: usize = files.iter().map(|file| file.rows()).sum();
    let looked_at = (share * rows as f64) as usize;
    notes.push(format!(
        "{rows} rows are more than are looked at in one diagnosis (about {looked_at} at this sampling): stretches of {STRETCH_S} s, \
         spread evenly, stand for the rest; for an event that happened once, cut the recording around it"
    ));
    files.iter().map(|file| file.driven(&spread(&file.t_s, share))).collect()
}

/// Rows of the stretches that hold a share of all rows. Shares of the rows and not of the time: where a clock was set in the
/// middle of a log, nearly all of the time is in that gap.
fn spread(t_s: &[f64], share: f64) -> Vec<Range<usize>> {
    let rows = t_s.len() as f64;
    let count = (share * rows * median_period_s(t_s) / STRETCH_S).ceil().clamp(1.0, rows);
    let (each, stretch) = (rows / count, share * rows / count);
    let mut random = StdRng::seed_from_u64(SEED);
    let row = |at: f64| (at.round() as usize).min(t_s.len());
    let ranges = (0..count as usize).map(|index| {
        let from = each * index as f64 + random.random_range(0.0..=(each - stretch).max(0.0));
        row(from)..row(from + stretch)
    });
    let mut ranges: Vec<Range<usize>> = ranges.filter(|rows| rows.len() > 1).collect();
    if ranges.is_empty() {
        ranges.push(0..t_s.len());
    }
    ranges
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use plant::Model;

    use super::*;
    use crate::simulate::{Reference, Row, Setup, record, run};
    use er_servo::Config;
    use er_servo::experiment::{Experiment, Shape};

    /// Four seconds of steps of the paper's servo.
    fn recording() -> Recording {
        let shape = Shape::Steps { amplitude_rad: 0.9, dwell_s: 0.5, seed: 1 };
        let reference = Reference::Experiment(Experiment { shape, duration_s: 4.0 });
        let setup = Setup {
            model: Model::paper(),
            config: Config::default(),
            disturbances: Vec::new(),
            sensor_noise_rad: 0.0,
            torque_noise_nm: 0.0,
            seed: 1,
        };
        let rows: Vec<Row> = run(&setup, reference.positions(5e-4).unwrap()).unwrap();
        record("steps.csv", &rows)
    }

    #[test]
    fn a_short_recording_is_looked_at_whole_and_one_of_minutes_in_stretches() {
        let short = recording();
        let mut notes = Vec::new();
        let whole = stretches(&[&short], &mut notes);
        assert_eq!((whole[0].position.as_slice(), notes.len()), (short.position.as_slice(), 0));
        // Every row a hundred times: 400 s.
        let mut long = short.clone();
        long.t_s = (0..100u32).flat_map(|k| short.t_s.iter().map(move |t_s| t_s + 4.0 * f64::from(k))).collect();
        for column in [&mut long.position, &mut long.effort_cmd] {
            *column = column.repeat(100);
        }
        for column in [&mut long.field_cmd_kv_mm, &mut long.velocity] {
            *column = column.as_ref().map(|values| values.repeat(100));
        }
        long.mode = long.mode.map(|values| values.repeat(100));
        let part = &stretches(&[&long], &mut notes)[0];
        assert!(notes.len() == 1 && notes[0].contains("800000 rows"), "{notes:?}");
        assert!(part.rows().abs_diff(SUBSTEPS) < 100, "{}", part.rows());
        assert!(part.gaps.len() == 24 && part.gaps.iter().all(|&gap| part.t_s[gap + 1] - part.t_s[gap] > 5e-4));
        // The first and the last stretch lie in the first and the last share, of 16 s each.
        assert!(part.t_s.is_sorted() && part.t_s[0] < 16.0 && part.t_s[part.rows() - 1] > 384.0);
    }

    #[test]
    fn stretches_hold_their_share_and_follow_each_other() {
        let t_s: Vec<f64> = (0..10_000u32).map(|row| f64::from(row) * 0.01).collect();
        for share in [0.01, 0.3, 0.99] {
            let ranges = spread(&t_s, share);
            let rows: usize = ranges.iter().map(|rows| rows.len()).sum();
            assert!((rows as f64 / 10_000.0 - share).abs() < 0.003, "{share}: {rows}");
            assert!(ranges.windows(2).all(|pair| pair[0].end <= pair[1].start));
        }
    }

    /// A clock that is set while it is logged: fifty years in one step.
    #[test]
    fn a_leap_of_the_clock_takes_no_rows_away_and_no_time() {
        let leap = |row: u32| if row < 5000 { 0.0 } else { 1.7e9 };
        let t_s: Vec<f64> = (0..10_000u32).map(|row| f64::from(row) * 0.01 + leap(row)).collect();
        let ranges = spread(&t_s, 0.3);
        let rows: usize = ranges.iter().map(|rows| rows.len()).sum();
        assert!((rows as f64 / 10_000.0 - 0.3).abs() < 0.003 && ranges.len() == 6, "{rows} in {ranges:?}");
    }
}
