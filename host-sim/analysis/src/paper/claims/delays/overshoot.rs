//! "A large overshoot" of the lag of E: where it is, and where it is not.

use rayon::prelude::*;

use super::super::claim::{Claim, Verdict, scanned, trim_zeros};
use crate::paper::case::{Case, Fluid, Speed};
use crate::paper::scan::{Cell, Scan};
use recording::Error;

/// Overshoots this far apart are different, share of the step: the settling band.
pub(super) const OVERSHOOT: f64 = 0.02;

/// L of the gains, s.
const DELAYS_S: [f64; 5] = [0.0015, 0.002, 0.003, 0.005, 0.008];
/// Delay of the plant over that, 1.
const SLOWNESSES: [f64; 7] = [1.0, 1.25, 1.5, 1.75, 2.0, 2.2, 2.5];
/// Steps in u = c / K_P: the damper decides only where the rotor is slow all the way.
const STEPS_U: [f64; 8] = [3.0, 5.0, 7.0, 9.0, 11.0, 14.0, 18.0, 25.0];

/// How much further than without delay.
fn more(cell: &Cell, fluid: Fluid) -> f64 {
    cell.of(fluid).response.overshoot - cell.of(Fluid::None).response.overshoot
}

/// Overshoot of E lag 5 ms over that without delay, share of the step.
fn excess(delay_s: f64, slowness: f64, step_u: f64) -> Result<f64, Error> {
    let case = Case { gains_delay_s: delay_s, plant_delay_s: slowness * delay_s, ..Case::PAPER };
    let case = Case { step_rad: step_u * case.friction_error_rad(), ..case };
    let overshoot = |fluid| {
        let case = Case { fluid, ..case };
        let rows = case.run()?;
        Ok::<_, Error>(case.response(&rows).map_or(0.0, |response| response.overshoot))
    };
    Ok(overshoot(Fluid::ELag5)? - overshoot(Fluid::None)?)
}

/// At how many places of plants slower than the gains assume the overshoot is large, and a line for each slowness.
fn small_steps_on_slow_plants() -> Result<(usize, Vec<String>), Error> {
    let mut figures = Vec::new();
    let mut slower = 0;
    for slowness in SLOWNESSES {
        let places: Vec<(f64, f64)> = DELAYS_S.iter().flat_map(|delay| STEPS_U.map(|step| (*delay, step))).collect();
        let places: Vec<(f64, f64, f64)> = places
            .into_par_iter()
            .map(|(delay_s, step_u)| Ok((delay_s, step_u, excess(delay_s, slowness, step_u)?)))
            .collect::<Result<_, Error>>()?;
        let large = places.iter().filter(|place| place.2 >= OVERSHOOT);
        slower += if slowness > 1.0 { large.clone().count() } else { 0 };
        let worst = places.iter().fold((0.0, 0.0, f64::NEG_INFINITY), |a, b| if b.2 > a.2 { *b } else { a });
        figures.push(format!(
            "small steps, plant {slowness} times as slow: large at {} of {}; most {:.2} % more, L {} ms, step {} u",
            large.count(),
            places.len(),
            100.0 * worst.2,
            trim_zeros(&format!("{:.4}", worst.0 * 1e3)),
            worst.1
        ));
    }
    Ok((slower, figures))
}

pub(super) fn of_the_e_lag(scan: &Scan) -> Result<Claim, Error> {
    let as_assumed: Vec<f64> = scan.at(Speed::True, 1.0).map(|cell| more(cell, Fluid::ELag5)).collect();
    let with_counts = scan.at(Speed::Counts, 1.0).filter(|cell| more(cell, Fluid::ELag5) >= OVERSHOOT).count();
    let large = as_assumed.iter().filter(|more| **more >= OVERSHOOT).count();
    let most = as_assumed.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut figures = vec![format!(
        "plant as the gains assume: large at {large} of {} places, at most {:.2} % more; speed from counts: at {with_counts}",
        as_assumed.len(),
        100.0 * most
    )];
    let (slower, slow_plants) = small_steps_on_slow_plants()?;
    figures.extend(slow_plants);
    let slow_step = |cell: &&Cell| cell.point.gains_delay_s == 0.002 && cell.point.step_rad == 0.0055;
    for cell in scan.at(Speed::True, 2.2).filter(slow_step) {
        let models = [Fluid::Off, Fluid::None, Fluid::EDead5, Fluid::EDead2Lag3, Fluid::ELag5];
        let list = models.map(|fluid| format!("{} {:.2} %", fluid.name(), 100.0 * cell.of(fluid).response.overshoot));
        figures.push(format!("gains for 2 ms, plant 4.4 ms, 5.5 mrad: {}", list.join(", ")));
    }
    Ok(Claim {
        section: "VI-E, Fig. 16",
        statement: "A lag of 5 ms in E leaves too little damping and so a large overshoot",
        test: "overshoot at least 2 % of the step more than without delay",
        range: format!(
            "{}; and small steps of 3 to 25 u, L 1.5 to 8 ms, on plants 1 to 2.5 times as slow: {} places",
            scanned(as_assumed.len()),
            DELAYS_S.len() * STEPS_U.len() * SLOWNESSES.len()
        ),
        figures,
        verdict: match (large, slower) {
            (0, 0) => Verdict::DoesNotHold("at no place of the range".to_owned()),
            (0, _) => Verdict::HoldsOnly(format!(
                "the plant is slower than the gains assume, and the step small ({slower} places); nowhere with the plant as \
                 they assume"
            )),
            (n, _) => Verdict::HoldsOnly(format!("at {n} places with the plant as the gains assume")),
        },
    })
}
