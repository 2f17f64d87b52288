//! Section VI: the step responses under each delay model, judged over the range of the scan.

mod models;
mod overshoot;

use super::claim::{Claim, Verdict, View, Where, scanned};
use crate::paper::case::{COULOMB_NM, Fluid, Reading, STEP_RAD};
use crate::paper::scan::{Law, Scan};
pub(in crate::paper) use models::{FURTHEST, TESTS, Test};
use recording::Error;

pub(super) fn claims(scan: &Scan) -> Result<Vec<Claim>, Error> {
    let mut claims = Vec::new();
    for test in TESTS.iter().chain([&FURTHEST]) {
        let more = match test.section {
            "VI-A, Fig. 11" => overshoot::without_damper()?,
            "VI-A" => friction(scan),
            "VI-E, Fig. 16" if test.statement.contains("overshoot") => overshoot::elsewhere(scan)?,
            "VI-E" if test.statement.contains("insufficient") => shares(scan),
            "VI-E, Fig. 16" => residuals(scan),
            _ => Vec::new(),
        };
        claims.push(over_the_scan(scan, test, more));
    }
    claims.push(experiment());
    Ok(claims)
}

/// Figures of a model at a place.
fn described(view: &View, fluid: Fluid) -> String {
    let response = &view.of(fluid).response;
    let settling = response.settling_s.map_or("never".to_owned(), |s| format!("{:.1} ms", s * 1e3));
    let reading = if fluid.delays_viscosity() { format!(" ({})", view.reading.name()) } else { String::new() };
    format!(
        "30 degrees, L 5 ms, {}{reading}: overshoot {:.2} %, settles {settling}, residual {:.2} u, dips {}; path up to \
         {:.1} % of the step from the one without delay",
        fluid.name(),
        100.0 * response.overshoot,
        response.residual_u,
        response.dips,
        100.0 * view.of(fluid).from_prompt
    )
}

/// The step of control.md section 7 with a law and a reading.
fn papers_step(scan: &Scan, law: Law, reading: Reading) -> Option<View<'_>> {
    let mut cells = scan.at(law, 1.0);
    let cell = cells.find(|cell| cell.point.gains_delay_s == 0.005 && cell.point.step_rad == STEP_RAD)?;
    Some(View { cell, reading })
}

/// A claim that is true or not at each place of the scan: verdict over all places with the law as the paper has it and the
/// viscosity as a fluid can; the other laws and the other reading beside it.
fn over_the_scan(scan: &Scan, test: &Test, more: Vec<String>) -> Claim {
    let found = Where::of(scan, Law::PAPER, Reading::AsAFluid, test.holds);
    let mut figures = Vec::new();
    for fluid in test.show {
        let readings: &[Reading] = if fluid.delays_viscosity() { &Reading::ALL } else { &[Reading::AsAFluid] };
        let views = readings.iter().filter_map(|reading| papers_step(scan, Law::PAPER, *reading));
        figures.extend(views.map(|view| described(&view, *fluid)));
    }
    figures.extend(more);
    let counted = |law: Law, reading: Reading| {
        format!("{}, {}: at {}", reading.name(), law.name(), Where::of(scan, law, reading, test.holds))
    };
    let printed = Where::of(scan, Law::PAPER, Reading::AsPrinted, test.holds);
    let mut beside = String::new();
    // Without the runs that the law as flashed or holding has not: they would read as if it were false there.
    let laws: &[Law] = if test.section == "VI-A" { &[Law::PAPER] } else { &Law::ALL };
    for reading in Reading::ALL {
        let differs = reading == Reading::AsAFluid || Law::ALL.iter().any(|law| differ(scan, *law, test));
        figures.extend(laws.iter().filter(|_| differs).map(|law| counted(*law, reading)));
        if differs && reading == Reading::AsPrinted {
            let (yes, of) = printed.total();
            beside = format!("as printed: at {yes} of {of}");
        }
    }
    if test.statement.contains("cannot return") {
        let (yes, of) = Where::of(scan, Law::HOLDING, Reading::AsAFluid, test.holds).total();
        beside = format!("if the brake also holds at w = 0: at {yes} of {of}");
    }
    Claim {
        section: test.section,
        statement: test.statement,
        test: test.test,
        range: scanned(found.total().1),
        figures,
        verdict: found.verdict(&beside),
    }
}

/// Whether the readings differ anywhere with a law.
fn differ(scan: &Scan, law: Law, test: &Test) -> bool {
    scan.cells.iter().filter(|cell| cell.point.law == law).any(|cell| {
        let [fluid, printed] = Reading::ALL.map(|reading| (test.holds)(&View { cell, reading }));
        fluid != printed
    })
}

/// How far apart the models are with and without friction, for 30 degrees.
fn friction(scan: &Scan) -> Vec<String> {
    let cells = scan.at(Law::PAPER, 1.0).filter(|cell| cell.point.step_rad == STEP_RAD);
    let lines = cells.filter_map(|cell| {
        let (without, with) = (cell.apart_without_friction(Reading::AsAFluid)?, cell.apart(Reading::AsAFluid));
        Some(format!(
            "30 degrees, L {} ms: rest positions spread {:.3} mrad with friction 0, {:.3} with {COULOMB_NM} N m; at most {} \
             and {} dips",
            cell.point.gains_delay_s * 1e3,
            without.rest_rad * 1e3,
            with.rest_rad * 1e3,
            without.dips,
            with.dips
        ))
    });
    lines.collect()
}

/// Share of the commanded torque that acts on arrival, for 30 degrees.
fn shares(scan: &Scan) -> Vec<String> {
    let cells = scan.at(Law::PAPER, 1.0).filter(|cell| cell.point.step_rad == STEP_RAD);
    let lines = cells.filter_map(|cell| {
        let share = cell.of(Reading::AsAFluid, Fluid::ELag5).arrival?;
        let delay_ms = cell.point.gains_delay_s * 1e3;
        Some(format!("30 degrees, L {delay_ms} ms: {:.0} % of the commanded torque acts", 100.0 * share))
    });
    lines.collect()
}

/// Rest positions of the step of 30 degrees under every model, with both brakes.
fn residuals(scan: &Scan) -> Vec<String> {
    let line = |(law, brake): (Law, &str)| {
        let view = papers_step(scan, law, Reading::AsAFluid)?;
        let list = Fluid::ALL.map(|fluid| format!("{} {:.2}", fluid.name(), view.of(fluid).response.residual_u));
        Some(format!("30 degrees, L 5 ms, {brake} brake, residual in u: {}", list.join(", ")))
    };
    [(Law::PAPER, "strict"), (Law::HOLDING, "holding")].into_iter().filter_map(line).collect()
}

fn experiment() -> Claim {
    Claim {
        section: "VI-F, VII, Figs. 11, 12 to 19",
        statement: "E dead 2 + lag 3 ms is the closest to the experiment",
        test: "none",
        range: "none".to_owned(),
        figures: vec![
            "the figures are drawn from the simulation alone; `paper --measured FILE` draws a recording into them"
                .to_owned(),
        ],
        verdict: Verdict::NotTestable(
            "the measured curves and the measured friction of Fig. 10 are not available".to_owned(),
        ),
    }
}
