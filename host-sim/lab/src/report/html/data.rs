//! What the page draws.

use serde::Serialize;

use super::maps::{self, MapPlot};
use super::{thin, windows};
use crate::Error;
use crate::conclude::Diagnosis;
use crate::read::Recording;
use crate::report::{Units, Verdict};
use crate::residual::Residual;

/// Rows drawn of all recordings together: a page of some 2 MB that a browser zooms without delay.
const ROWS: usize = 60_000;
/// Rows drawn of one recording, at least.
const ROWS_OF_ONE: usize = 4000;

/// Curves and maps of a diagnosis; computed only where a page is asked for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlotData {
    /// Unit of positions.
    pub(super) position_unit: &'static str,
    /// Unit of the residuals, with an SI prefix.
    pub(super) residual_unit: String,
    /// torque or force.
    pub(super) effort_name: &'static str,
    /// Unit of torque or force.
    pub(super) effort_unit: &'static str,
    /// Recordings that were fitted, then those held out.
    pub(super) recordings: Vec<RecordingPlot>,
    /// Residual torque before and after over the channels of state.
    pub(super) maps: Vec<MapPlot>,
    /// Length of the windows, s; of recordings that differ, the longest.
    #[serde(skip)]
    pub(super) window_s: f64,
}

/// Curves of one recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct RecordingPlot {
    pub name: String,
    pub held_out: bool,
    /// Rows of the file; more than are drawn where it is long.
    pub rows: usize,
    pub t_s: Samples,
    pub recorded: Samples,
    /// Recorded minus simulated by the nominal model.
    pub before: Samples,
    /// Recorded minus simulated by the improved model; none where no physics was added.
    pub after: Option<Samples>,
    pub effort: Samples,
    pub field_kv_mm: Option<Samples>,
    /// Spans of time named in the answer: start, end, s.
    pub spans: Vec<(f64, f64)>,
}

/// Values as whole numbers of a step: short in JSON, and no digits that no screen can show.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Samples {
    pub step: f64,
    pub at: Vec<Option<i64>>,
}

impl PlotData {
    /// Simulates the nominal and the improved machine of a diagnosis over its recordings, in the order in which it had them.
    ///
    /// # Errors
    /// A recording too short for one window, or a machine that cannot be simulated.
    pub fn new(diagnosis: &Diagnosis, recordings: &[Recording], holdout: &[Recording]) -> Result<Self, Error> {
        let answer = &diagnosis.answer;
        let files: Vec<&Recording> = recordings.iter().chain(holdout).collect();
        // Where the controller is wrong, or nothing is missing, there is no improved model to show.
        let physics = !answer.effects.is_empty() && answer.verdict != Verdict::Controller;
        let before = windows::all(&diagnosis.nominal, &files)?;
        let after = if physics { Some(windows::all(&diagnosis.improved, &files)?) } else { None };
        let units = Units::of(files.first().map_or(crate::read::AxisKind::Rotary, |recording| recording.axis));
        let (prefix, factor) = prefix(largest(&before));
        let most = (ROWS / files.len().max(1)).max(ROWS_OF_ONE);
        let plots = files.iter().enumerate().map(|(index, recording)| {
            let residuals = (&before[index], after.as_ref().map(|after| &after[index]));
            let mut plot = RecordingPlot::new(recording, residuals, factor, most);
            plot.held_out = index >= recordings.len();
            let spans = answer.locations.iter().filter(|location| location.recording == recording.name);
            plot.spans = spans.map(|location| (location.start_s, location.end_s)).collect();
            plot
        });
        Ok(Self {
            position_unit: units.position,
            residual_unit: format!("{prefix}{}", units.position),
            effort_name: units.effort_name,
            effort_unit: units.effort,
            recordings: plots.collect(),
            maps: maps::all(&files, &before, after.as_deref(), units),
            window_s: before.iter().map(|residual| residual.horizon_s).fold(0.0, f64::max),
        })
    }
}

impl RecordingPlot {
    fn new(recording: &Recording, (before, after): (&Residual, Option<&Residual>), factor: f64, most: usize) -> Self {
        let rows = recording.rows();
        let before = by_row(before, rows, factor);
        let after = after.map(|after| by_row(after, rows, factor));
        let mut columns: Vec<&[f64]> = vec![&recording.position, &before, &recording.effort_cmd];
        columns.extend(after.as_deref());
        columns.extend(recording.field_cmd_kv_mm.as_deref());
        let kept = with_gaps(&thin::kept(rows, &columns, most), &recording.gaps);
        Self {
            name: recording.name.clone(),
            held_out: false,
            rows,
            t_s: Samples::times(&recording.t_s, &kept),
            recorded: Samples::new(&recording.position, &kept, 1e-6),
            before: Samples::new(&before, &kept, 1e-4),
            after: after.map(|after| Samples::new(&after, &kept, 1e-4)),
            effort: Samples::new(&recording.effort_cmd, &kept, 1e-4),
            field_kv_mm: recording.field_cmd_kv_mm.as_ref().map(|field| Samples::new(field, &kept, 1e-4)),
            spans: Vec::new(),
        }
    }
}

/// A row drawn, or a break after a row.
#[derive(Debug, Clone, Copy)]
enum Drawn {
    Row(usize),
    BreakAfter(usize),
}

/// Breaks the curves where samples are missing.
fn with_gaps(kept: &[usize], gaps: &[usize]) -> Vec<Drawn> {
    let mut drawn = Vec::with_capacity(kept.len() + gaps.len());
    for (index, &row) in kept.iter().enumerate() {
        drawn.push(Drawn::Row(row));
        let next = kept.get(index + 1).copied().unwrap_or(row);
        let gap = gaps.partition_point(|gap| *gap < row);
        if gaps.get(gap).is_some_and(|gap| *gap < next) {
            drawn.push(Drawn::BreakAfter(row));
        }
    }
    drawn
}

impl Samples {
    /// Rounded to a step of `resolution` times the largest value, down to a power of ten; not a number is a break.
    fn new(values: &[f64], drawn: &[Drawn], resolution: f64) -> Self {
        let largest =
            values.iter().filter(|value| value.is_finite()).fold(0.0_f64, |most, value| most.max(value.abs()));
        let step = if largest > 0.0 { 10.0_f64.powf((largest * resolution).log10().floor()) } else { 1.0 };
        let at = drawn.iter().map(|drawn| match *drawn {
            Drawn::Row(row) if values[row].is_finite() => Some((values[row] / step).round() as i64),
            Drawn::Row(_) | Drawn::BreakAfter(_) => None,
        });
        Self { step, at: at.collect() }
    }

    /// Times to the microsecond; a break stands just after the row before it.
    fn times(t_s: &[f64], drawn: &[Drawn]) -> Self {
        let at = drawn.iter().map(|drawn| match *drawn {
            Drawn::Row(row) => Some((t_s[row] * 1e6).round() as i64),
            Drawn::BreakAfter(row) => Some((t_s[row] * 1e6).round() as i64 + 1),
        });
        Self { step: 1e-6, at: at.collect() }
    }
}

/// Residual of each row times `factor`; not a number where no window is.
fn by_row(residual: &Residual, rows: usize, factor: f64) -> Vec<f64> {
    let mut values = vec![f64::NAN; rows];
    for window in &residual.windows {
        for (value, residual) in values[window.start..window.end].iter_mut().zip(&window.residual) {
            *value = residual * factor;
        }
    }
    values
}

fn largest(residuals: &[Residual]) -> f64 {
    let windows = residuals.iter().flat_map(|residual| &residual.windows);
    windows.flat_map(|window| &window.residual).fold(0.0, |most, value| most.max(value.abs()))
}

/// SI prefix in which a value has one to three digits before the point, and its factor.
pub(super) fn prefix(largest: f64) -> (&'static str, f64) {
    match largest {
        value if value >= 1.0 => ("", 1.0),
        value if value >= 1e-3 => ("m", 1e3),
        value if value >= 1e-6 => ("\u{b5}", 1e6),
        _ => ("n", 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_breaks_the_curve_even_where_rows_are_thinned() {
        let drawn = with_gaps(&[0, 3, 4, 5], &[1, 4]);
        let breaks: Vec<_> = drawn.iter().map(|drawn| matches!(drawn, Drawn::BreakAfter(_))).collect();
        assert_eq!(breaks, [false, true, false, false, true, false]);
    }

    #[test]
    fn samples_are_whole_numbers_of_a_round_step() {
        let samples = Samples::new(&[0.5, -0.25, f64::NAN], &[Drawn::Row(0), Drawn::Row(1), Drawn::Row(2)], 1e-2);
        assert_eq!(samples.at, [Some(500), Some(-250), None]);
        assert!((samples.step - 1e-3).abs() < 1e-12);
    }
}
