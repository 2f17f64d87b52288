//! What the page draws.

use diagnosis::confidence_set::TWO_SIDED_95;
use serde::Serialize;

use super::maps::{self, MapPlot};
use super::whiteness::{self, Curve};
use super::{equation, thin, windows};
use crate::Error;
use crate::conclude::Diagnosis;
use crate::read::{AxisKind, Recording};
use crate::report::{FitAnswer, Units, Verdict};
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
    /// What is left of each sample, as noise.
    pub(super) left: Vec<Curve>,
    /// The recording whose residual stands at the top.
    pub(super) first: usize,
    /// The improved model, a line each.
    #[serde(skip)]
    pub(super) equation: Vec<String>,
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
    /// Residuals of noise alone are within this either way in 95 % of all rows, in the unit of the residuals.
    pub noise: f64,
    /// How much of the motion is predicted.
    #[serde(skip)]
    pub fit: Fit,
}

/// Share of what a steady speed leaves within the windows that a model predicts, root mean square, up to 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Fit {
    pub nominal: f64,
    /// None where no physics was added.
    pub improved: Option<f64>,
    /// What noise leaves to a perfect model.
    pub noise: f64,
}

impl Fit {
    fn new(recording: &Recording, before: &Residual, after: Option<&Residual>, noise_rms: f64) -> Self {
        let steady_rms = steady_rms(recording, before);
        let fit = |rms: f64| if steady_rms > 0.0 { 1.0 - rms / steady_rms } else { f64::NAN };
        Self { nominal: fit(before.rms()), improved: after.map(|after| fit(after.rms())), noise: fit(noise_rms) }
    }
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
        let shown = if physics { &diagnosis.improved } else { &diagnosis.nominal };
        let before = windows::all(&diagnosis.nominal, &files)?;
        let after = if physics { Some(windows::all(&diagnosis.improved, &files)?) } else { None };
        let axis = files.first().map_or(AxisKind::Rotary, |recording| recording.axis);
        let units = Units::of(axis);
        let (prefix, factor) = prefix(largest(&before));
        let held = recordings.len();
        let noise_rms = noise_rms(&answer.fit, after.as_deref().unwrap_or(&before), held);
        let most = (ROWS / files.len().max(1)).max(ROWS_OF_ONE);
        let plots = files.iter().enumerate().map(|(index, recording)| {
            let residuals = (&before[index], after.as_ref().map(|after| &after[index]));
            let mut plot = RecordingPlot::new(recording, residuals, factor, most);
            plot.held_out = index >= held;
            plot.noise = TWO_SIDED_95 * factor * noise_rms[index];
            plot.fit = Fit::new(recording, &before[index], residuals.1, noise_rms[index]);
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
            left: whiteness::curves(&diagnosis.whitened, physics),
            // What nothing was fitted to shows best what the model is worth.
            first: if holdout.is_empty() { 0 } else { held },
            equation: equation::lines(shown, answer, axis),
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
            noise: 0.0,
            fit: Fit::default(),
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

/// What noise alone leaves of each recording, root mean square, rad (m). The answer's windows start from the filter's estimate, those
/// drawn from their best start, which leaves less; the share of it that is noise is the same.
fn noise_rms(fit: &FitAnswer, shown: &[Residual], fitted: usize) -> Vec<f64> {
    let of = |group: &[Residual], floor_rms: f64, left_rms: f64| {
        let windows = group.iter().flat_map(|one| &one.windows).flat_map(|window| &window.residual);
        let (squares, rows) = windows.fold((0.0, 0.0), |(squares, rows), left| (squares + left * left, rows + 1.0));
        let share = if left_rms > 0.0 { (floor_rms / left_rms).min(1.0) } else { 1.0 };
        vec![share * (squares / f64::max(rows, 1.0)).sqrt(); group.len()]
    };
    let (fitted, held) = shown.split_at(fitted.min(shown.len()));
    let first = of(fitted, fit.noise_floor_rms, fit.after_rms);
    first.into_iter().chain(of(held, fit.heldout_floor_rms, fit.heldout_after_rms)).collect()
}

/// What the best straight line through each window leaves of the recorded position, root mean square, rad (m).
fn steady_rms(recording: &Recording, residual: &Residual) -> f64 {
    let (mut squares, mut rows) = (0.0, 0_usize);
    for window in &residual.windows {
        let range = window.start..window.end;
        let (t_s, position) = (&recording.t_s[range.clone()], &recording.position[range]);
        let count = t_s.len() as f64;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
        let (t_mean, mean) = (mean(t_s), mean(position));
        let of = |t: f64, p: f64| (t - t_mean, p - mean);
        let (tt, tp) = t_s.iter().zip(position).fold((0.0, 0.0), |(tt, tp), (t, p)| {
            let (t, p) = of(*t, *p);
            (tt + t * t, tp + t * p)
        });
        let slope = if tt > 0.0 { tp / tt } else { 0.0 };
        let left = t_s.iter().zip(position).map(|(t, p)| {
            let (t, p) = of(*t, *p);
            p - slope * t
        });
        squares += left.map(|left| left * left).sum::<f64>();
        rows += t_s.len();
    }
    (squares / rows.max(1) as f64).sqrt()
}

fn largest(residuals: &[Residual]) -> f64 {
    let windows = residuals.iter().flat_map(|residual| &residual.windows);
    windows.flat_map(|window| &window.residual).fold(0.0, |most, value| most.max(value.abs()))
}

/// SI prefix in which a value has one to three digits before the point, and its factor.
pub(crate) fn prefix(largest: f64) -> (&'static str, f64) {
    match largest {
        value if value >= 1.0 => ("", 1.0),
        value if value >= 1e-3 => ("m", 1e3),
        value if value >= 1e-6 => ("\u{b5}", 1e6),
        _ => ("n", 1e9),
    }
}

#[cfg(test)]
mod tests {
    use plant::State;

    use super::*;
    use crate::residual::Window;

    #[test]
    fn a_gap_breaks_the_curve_even_where_rows_are_thinned() {
        let drawn = with_gaps(&[0, 3, 4, 5], &[1, 4]);
        let breaks: Vec<_> = drawn.iter().map(|drawn| matches!(drawn, Drawn::BreakAfter(_))).collect();
        assert_eq!(breaks, [false, true, false, false, true, false]);
    }

    #[test]
    fn noise_is_the_share_of_what_is_left_that_the_answer_says() {
        let window = |left: f64| Window {
            start: 0,
            end: 2,
            state: State::new(0.0, 0.0),
            residual: vec![left, -left],
            torque: 0.0,
            speed: 0.0,
        };
        let residual = |left: f64| Residual { horizon_s: 0.05, windows: vec![window(left)] };
        let fit = FitAnswer {
            after_rms: 4.0,
            noise_floor_rms: 2.0,
            heldout_after_rms: 1.0,
            heldout_floor_rms: 3.0,
            ..FitAnswer::default()
        };
        let found = noise_rms(&fit, &[residual(6.0), residual(8.0)], 1);
        assert_eq!(found, [3.0, 8.0], "never more than is left");
        assert_eq!(noise_rms(&fit, &[], 1), [0.0; 0]);
    }

    #[test]
    fn samples_are_whole_numbers_of_a_round_step() {
        let samples = Samples::new(&[0.5, -0.25, f64::NAN], &[Drawn::Row(0), Drawn::Row(1), Drawn::Row(2)], 1e-2);
        assert_eq!(samples.at, [Some(500), Some(-250), None]);
        assert!((samples.step - 1e-3).abs() < 1e-12);
    }
}
