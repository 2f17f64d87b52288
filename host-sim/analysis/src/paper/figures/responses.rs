//! Figs. 12 to 19: responses in time.

use rayon::prelude::*;

use super::NamedFigure;
use crate::paper::case::{Case, Fluid, PUSH, Speed};
use crate::plot::{Figure, Mark, Panel, Series};
use crate::simulate::{Disturbance, Row};
use recording::Error;

/// Shown of a step response, s.
const SHOWN_S: f64 = 0.25;

/// A run and its name in the legend.
type Named = (String, Vec<Row>);

pub(super) fn figures() -> Result<Vec<NamedFigure>, Error> {
    let mut figures = Vec::new();
    for (file, title, fluids) in [
        ("fig12.svg", "Fig. 12: dead time of Q, 5 ms", &[Fluid::QNone, Fluid::QDead5][..]),
        ("fig13.svg", "Fig. 13: dead time of Q, 50 ms", &[Fluid::QNone, Fluid::QDead50]),
        ("fig14.svg", "Fig. 14: dead time of E, 5 ms", &[Fluid::None, Fluid::EDead5]),
        ("fig15.svg", "Fig. 15: lag of Q, 5 ms", &[Fluid::QNone, Fluid::QLag5]),
        ("fig16.svg", "Fig. 16: lag of E, 5 ms", &[Fluid::None, Fluid::ELag5]),
        ("fig17.svg", "Fig. 17: dead time 2 ms and lag 3 ms of E", &[Fluid::None, Fluid::EDead2Lag3]),
    ] {
        let cases = fluids.iter().map(|fluid| (fluid.name().to_owned(), Case { fluid: *fluid, ..Case::PAPER }));
        figures.push(step(file, &format!("{title}; 30 degree step, L 5 ms"), &runs(cases.collect())?, SHOWN_S));
    }
    figures.push(slow_plant()?);
    figures.push(torque()?);
    figures.push(disturbed()?);
    figures.push(from_counts()?);
    Ok(figures)
}

fn runs(cases: Vec<(String, Case)>) -> Result<Vec<Named>, Error> {
    cases.into_par_iter().map(|(name, case)| Ok((name, case.run()?))).collect()
}

fn panel(label: &str, mark: Mark, runs: &[Named], until_s: f64, value: fn(&Row) -> f64) -> Panel {
    let series = runs.iter().map(|(name, rows)| {
        let shown = rows.iter().filter(|row| row.t_s <= until_s);
        Series::new(name, mark, shown.map(|row| (row.t_s, value(row))))
    });
    Panel::new("time (s)", label, series.collect())
}

fn step(file: &'static str, title: &str, runs: &[Named], until_s: f64) -> NamedFigure {
    let panels = vec![
        panel("position (rad)", Mark::Line, runs, until_s, |row| row.truth.position),
        panel("speed (rad/s)", Mark::Line, runs, until_s, |row| row.truth.velocity),
        panel("field command (kV/mm)", Mark::Step, runs, until_s, |row| f64::from(row.outputs.field_kv_mm)),
    ];
    NamedFigure { file, figure: Figure { title: title.to_owned(), panels } }
}

/// Where the large overshoot of Fig. 16 does appear.
fn slow_plant() -> Result<NamedFigure, Error> {
    let fluids = [Fluid::Off, Fluid::None, Fluid::EDead5, Fluid::EDead2Lag3, Fluid::ELag5];
    let case = Case { gains_delay_s: 0.002, plant_delay_s: 0.0044, step_rad: 0.0055, ..Case::PAPER };
    let runs = runs(fluids.map(|fluid| (fluid.name().to_owned(), Case { fluid, ..case })).to_vec())?;
    let title = "Fig. 16 on a plant slower than its gains assume: gains for 2 ms, plant 4.4 ms, 5.5 mrad";
    Ok(step("fig16_slow_plant.svg", title, &runs, 0.08))
}

fn torque() -> Result<NamedFigure, Error> {
    let runs = runs(vec![("E dead 2 + lag 3 ms".to_owned(), Case { fluid: Fluid::EDead2Lag3, ..Case::PAPER })])?;
    let panels =
        vec![panel("motor torque command (N m)", Mark::Step, &runs, SHOWN_S, |row| f64::from(row.outputs.torque_nm))];
    let figure = Figure { title: "Fig. 18: torque of Fig. 17".to_owned(), panels };
    Ok(NamedFigure { file: "fig18.svg", figure })
}

fn disturbed() -> Result<NamedFigure, Error> {
    let push = Some(Disturbance { start_s: 0.4, ..PUSH });
    let case = Case { push, ..Case::PAPER };
    let both = Fluid::EDead2Lag3;
    let runs = runs(vec![
        ("ER off".to_owned(), Case { fluid: Fluid::Off, ..case }),
        ("damper only".to_owned(), Case { fluid: both, brake: false, ..case }),
        ("damper and brake".to_owned(), Case { fluid: both, ..case }),
    ])?;
    let title = "Fig. 19: step, then 8 N m for 50 ms at 0.4 s; E dead 2 + lag 3 ms, L 5 ms";
    let mut figure = step("fig19.svg", title, &runs, 0.7);
    // The push moves the rotor by a twentieth of the step.
    let error = panel("error near rest (mrad)", Mark::Line, &runs, 0.7, |row| {
        let error_mrad = 1e3 * (row.reference.to_rad() - row.truth.position);
        if error_mrad.abs() < 40.0 { error_mrad } else { f64::NAN }
    });
    figure.figure.panels.insert(1, error);
    Ok(figure)
}

/// Not in the paper: what the speed estimate of the firmware changes.
fn from_counts() -> Result<NamedFigure, Error> {
    let case = Case { fluid: Fluid::EDead2Lag3, ..Case::PAPER };
    let runs = runs(vec![
        ("true speed".to_owned(), case),
        ("speed from counts".to_owned(), Case { speed: Speed::Counts, ..case }),
    ])?;
    Ok(step("speed_from_counts.svg", "Fig. 17 with the speed the firmware has", &runs, SHOWN_S))
}
