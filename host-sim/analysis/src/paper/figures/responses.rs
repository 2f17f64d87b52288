//! Figs. 12 to 19: responses in time.

use rayon::prelude::*;

use super::NamedFigure;
use crate::paper::case::{A, B, Case, Fluid, PUSH, Reading, STEP_RAD, Speed};
use crate::plot::{Figure, Mark, Panel, Series, Stroke};
use crate::simulate::{Disturbance, Row, field_kv_mm};
use recording::{Error, Recording};

/// Shown of a step response, s.
const SHOWN_S: f64 = 0.25;
/// Errors shown in the zoom around rest, mrad: twice the brake's zone.
const ZOOM_MRAD: f64 = 40.0;

/// A run with its name in the legend and its line: solid the model, dotted without delay, as the paper draws them.
struct Run {
    name: String,
    stroke: Stroke,
    rows: Vec<Row>,
}

pub(super) fn figures(measured: Option<&Recording>) -> Result<Vec<NamedFigure>, Error> {
    let mut figures = Vec::new();
    for (file, title, fluids) in [
        ("fig12.svg", "Fig. 12: dead time of Q, 5 ms", [Fluid::QNone, Fluid::QDead5]),
        ("fig13.svg", "Fig. 13: dead time of Q, 50 ms", [Fluid::QNone, Fluid::QDead50]),
        ("fig14.svg", "Fig. 14: dead time of E, 5 ms", [Fluid::None, Fluid::EDead5]),
        ("fig15.svg", "Fig. 15: lag of Q, 5 ms", [Fluid::QNone, Fluid::QLag5]),
        ("fig16.svg", "Fig. 16: lag of E, 5 ms", [Fluid::None, Fluid::ELag5]),
        ("fig17.svg", "Fig. 17: dead time 2 ms and lag 3 ms of E", [Fluid::None, Fluid::EDead2Lag3]),
    ] {
        let title = format!("{title}; 30 degree step, L 5 ms");
        figures.push(step(file, &title, &runs(papers(fluids))?, SHOWN_S, measured));
    }
    figures.push(slow_plant()?);
    figures.push(torque(measured)?);
    figures.push(disturbed()?);
    figures.push(from_counts()?);
    Ok(figures)
}

/// Without delay dotted, the model solid, and where its two readings differ, as printed dot-dashed.
fn papers([prompt, model]: [Fluid; 2]) -> Vec<(String, Stroke, Case)> {
    let case = |fluid| Case { fluid, ..Case::PAPER };
    let mut cases = vec![(prompt.name().to_owned(), Stroke::Dotted, case(prompt))];
    if model.delays_viscosity() {
        let named = |reading: Reading| format!("{}, {}", model.name(), reading.name());
        let of = |reading| Case { reading, ..case(model) };
        cases.push((named(Reading::AsAFluid), Stroke::Solid, of(Reading::AsAFluid)));
        cases.push((named(Reading::AsPrinted), Stroke::DashDot, of(Reading::AsPrinted)));
    } else {
        cases.push((model.name().to_owned(), Stroke::Solid, case(model)));
    }
    cases
}

fn runs(cases: Vec<(String, Stroke, Case)>) -> Result<Vec<Run>, Error> {
    cases.into_par_iter().map(|(name, stroke, case)| Ok(Run { name, stroke, rows: case.run()? })).collect()
}

fn panel(label: &str, mark: Mark, runs: &[Run], until_s: f64, value: fn(&Row) -> f64) -> Panel {
    let series = runs.iter().map(|run| {
        let shown = run.rows.iter().filter(|row| row.t_s <= until_s);
        Series::new(&run.name, mark, shown.map(|row| (row.t_s, value(row)))).with(run.stroke)
    });
    Panel::new("time (s)", label, series.collect())
}

fn error_mrad(row: &Row) -> f64 {
    let error_mrad = 1e3 * (row.reference.to_rad() - row.truth.position);
    if error_mrad.abs() < ZOOM_MRAD { error_mrad } else { f64::NAN }
}

/// The field that acts: that whose a E^2 + b E is the fluid's torque, for a delayed viscosity too.
fn acting_kv_mm(row: &Row) -> f64 {
    field_kv_mm((A, B), row.er_torque_nm)
}

fn step(file: &'static str, title: &str, runs: &[Run], until_s: f64, measured: Option<&Recording>) -> NamedFigure {
    let mut panels = vec![
        panel("position (rad)", Mark::Line, runs, until_s, |row| row.truth.position),
        panel("error near rest (mrad)", Mark::Line, runs, until_s, error_mrad),
        panel("speed (rad/s)", Mark::Line, runs, until_s, |row| row.truth.velocity),
        panel("field that acts (kV/mm)", Mark::Line, runs, until_s, acting_kv_mm),
    ];
    if let Some(recording) = measured {
        let position = overlaid(recording, until_s, &recording.position);
        let error = position.iter().map(|(t_s, position)| (*t_s, 1e3 * (STEP_RAD - position)));
        let error: Vec<_> = error.filter(|(_, error)| error.abs() < ZOOM_MRAD).collect();
        panels[0].series.push(Series::new("measured", Mark::Line, position).with(Stroke::Dashed));
        panels[1].series.push(Series::new("measured", Mark::Line, error).with(Stroke::Dashed));
    }
    NamedFigure { file, figure: Figure { title: title.to_owned(), panels } }
}

/// A column of a recording from its first row on, as far as the figure reaches.
fn overlaid(recording: &Recording, until_s: f64, column: &[f64]) -> Vec<(f64, f64)> {
    let start_s = recording.t_s.first().copied().unwrap_or(0.0);
    let rows = recording.t_s.iter().map(|t_s| t_s - start_s).zip(column.iter().copied());
    rows.take_while(|(t_s, _)| *t_s <= until_s).collect()
}

/// Where the large overshoot of Fig. 16 does appear.
fn slow_plant() -> Result<NamedFigure, Error> {
    let case = Case { gains_delay_s: 0.002, plant_delay_s: 0.0044, step_rad: 0.0055, ..Case::PAPER };
    let cases = [
        (Fluid::Off, Stroke::DashDot),
        (Fluid::None, Stroke::Dotted),
        (Fluid::EDead5, Stroke::Dashed),
        (Fluid::EDead2Lag3, Stroke::Solid),
        (Fluid::ELag5, Stroke::Solid),
    ];
    let runs = runs(cases.map(|(fluid, stroke)| (fluid.name().to_owned(), stroke, Case { fluid, ..case })).to_vec())?;
    let title = "Fig. 16 on a plant slower than its gains assume: gains for 2 ms, plant 4.4 ms, 5.5 mrad";
    Ok(step("fig16_slow_plant.svg", title, &runs, 0.08, None))
}

fn torque(measured: Option<&Recording>) -> Result<NamedFigure, Error> {
    let case = Case { fluid: Fluid::EDead2Lag3, ..Case::PAPER };
    let runs = runs(vec![("E dead 2 + lag 3 ms".to_owned(), Stroke::Solid, case)])?;
    let command = |row: &Row| f64::from(row.outputs.torque_nm);
    let mut panel = panel("motor torque command (N m)", Mark::Step, &runs, SHOWN_S, command);
    if let Some(recording) = measured {
        let torque = overlaid(recording, SHOWN_S, &recording.effort_cmd);
        panel.series.push(Series::new("measured", Mark::Step, torque).with(Stroke::Dashed));
    }
    let figure = Figure { title: "Fig. 18: torque of Fig. 17".to_owned(), panels: vec![panel] };
    Ok(NamedFigure { file: "fig18.svg", figure })
}

fn disturbed() -> Result<NamedFigure, Error> {
    let push = Some(Disturbance { start_s: 0.4, ..PUSH });
    let case = Case { push, ..Case::PAPER };
    let both = Fluid::EDead2Lag3;
    let runs = runs(vec![
        ("ER off".to_owned(), Stroke::Dotted, Case { fluid: Fluid::Off, ..case }),
        ("damper only".to_owned(), Stroke::Dashed, Case { fluid: both, brake: false, ..case }),
        ("damper and brake".to_owned(), Stroke::Solid, Case { fluid: both, ..case }),
    ])?;
    let title = "Fig. 19: step, then 8 N m for 50 ms at 0.4 s; E dead 2 + lag 3 ms, L 5 ms";
    Ok(step("fig19.svg", title, &runs, 0.7, None))
}

/// Not in the paper: what the speed estimate of the firmware changes.
fn from_counts() -> Result<NamedFigure, Error> {
    let case = Case { fluid: Fluid::EDead2Lag3, ..Case::PAPER };
    let runs = runs(vec![
        ("true speed".to_owned(), Stroke::Dotted, case),
        ("speed from counts".to_owned(), Stroke::Solid, Case { speed: Speed::Counts, ..case }),
    ])?;
    Ok(step("speed_from_counts.svg", "Fig. 17 with the speed the firmware has", &runs, SHOWN_S, None))
}
