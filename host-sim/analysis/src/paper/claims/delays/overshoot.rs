//! "A large overshoot" of the lag of E: where it is, and where it is not.

use rayon::prelude::*;

use super::models::{OVERSHOOT, more_overshoot};
use crate::paper::case::{Case, Fluid, Reading};
use crate::paper::claims::claim::{View, trim_zeros};
use crate::paper::scan::{Cell, GAINS_DELAYS_S, Law, Scan};
use recording::Error;

/// L of the gains, s.
const DELAYS_S: [f64; 5] = [0.0015, 0.002, 0.003, 0.005, 0.008];
/// Delay of the plant over that, 1.
const SLOWNESSES: [f64; 7] = [1.0, 1.25, 1.5, 1.75, 2.0, 2.2, 2.5];
/// Steps in u = c / K_P: the damper decides only where the rotor is slow all the way.
const STEPS_U: [f64; 8] = [3.0, 5.0, 7.0, 9.0, 11.0, 14.0, 18.0, 25.0];

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

/// At how many places the overshoot is large, and a line for each slowness.
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
        slower += large.clone().count();
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

/// Small steps on slower plants, and the step of control.md section 7.
pub(super) fn elsewhere(scan: &Scan) -> Result<Vec<String>, Error> {
    let views = scan.at(Law::PAPER, 1.0).map(|cell| View { cell, reading: Reading::AsAFluid });
    let most = views.map(|view| more_overshoot(&view)).fold(f64::NEG_INFINITY, f64::max);
    let mut figures = vec![format!("plant as the gains assume: at most {:.2} % more", 100.0 * most)];
    let (slower, slow_plants) = small_steps_on_slow_plants()?;
    let tried = DELAYS_S.len() * STEPS_U.len() * SLOWNESSES.len();
    figures.push(format!(
        "small steps of 3 to 25 u, L 1.5 to 8 ms, plants 1 to 2.5 times as slow: at {slower} of {tried}"
    ));
    figures.extend(slow_plants);
    let slow_step = |cell: &&Cell| cell.point.gains_delay_s == 0.002 && cell.point.step_rad == 0.0055;
    for cell in scan.at(Law::PAPER, 2.2).filter(slow_step) {
        let models = [Fluid::Off, Fluid::None, Fluid::EDead5, Fluid::EDead2Lag3, Fluid::ELag5];
        let overshoot = |fluid| 100.0 * cell.of(Reading::AsAFluid, fluid).response.overshoot;
        let list = models.map(|fluid| format!("{} {:.2} %", fluid.name(), overshoot(fluid)));
        figures.push(format!("gains for 2 ms, plant 4.4 ms, 5.5 mrad: {}", list.join(", ")));
    }
    Ok(figures)
}

/// From which slowness of the plant on 30 degrees overshoot by 2 % with the damper off: what a vibration without ER says of
/// L, which the paper does not give.
pub(super) fn without_damper() -> Result<Vec<String>, Error> {
    let line = |delay_s: &f64| {
        let overshoots = |slowness: f64| {
            let case =
                Case { fluid: Fluid::Off, gains_delay_s: *delay_s, plant_delay_s: slowness * delay_s, ..Case::PAPER };
            let rows = case.run()?;
            Ok::<_, Error>(case.response(&rows).is_some_and(|response| response.overshoot >= OVERSHOOT))
        };
        // Halved until 1 % is left of an octave and a half.
        let (mut calm, mut vibrates) = (1.0, 2.8);
        let of_gains = format!("gains for {} ms, 30 degrees", delay_s * 1e3);
        if overshoots(calm)? {
            return Ok(format!("{of_gains}: a plant as fast as they assume vibrates too, which says nothing of L"));
        }
        if !overshoots(vibrates)? {
            return Ok(format!("{of_gains}: no plant up to {vibrates} times as slow vibrates"));
        }
        while vibrates - calm > 0.01 {
            let middle = 0.5 * (calm + vibrates);
            if overshoots(middle)? { vibrates = middle } else { calm = middle }
        }
        Ok(format!("{of_gains}: from a plant of {:.1} ms on, {vibrates:.2} times as slow", vibrates * delay_s * 1e3))
    };
    let mut lines = vec![
        "a clue to L: if Fig. 11 vibrates, and a plant as fast as the gains assume does not, the plant is slower"
            .to_owned(),
    ];
    lines.extend(GAINS_DELAYS_S.par_iter().map(line).collect::<Result<Vec<_>, Error>>()?);
    Ok(lines)
}
