//! Section VII: "it did not result in a destabilized state if the variations were within several dozen percent".

use er_servo::Config;
use rayon::prelude::*;

use super::region::{DEAD, DELAYS_S, LAG, PEAK_NM_S_RAD, closed, plant};
use super::{Claim, Verdict, refused};
use crate::Error;
use crate::paper::case::{COULOMB_NM, DELAY_S, INERTIA_KG_M2};
use crate::stability::describing::{Search, cycles_by_model};
use crate::stability::limits::{Quantity, tolerances};
use crate::stability::{Fluid, Loop, LoopError, NormalisedGains, curves};

/// "Several dozen percent": what every quantity must bear alone, up and down.
const DOZENS: [f64; 3] = [0.24, 0.36, 0.5];
/// Q1 of the range: least of (5), the figure's, the peak.
const VISCOSITIES: [f64; 5] = [0.158, 5.0, 10.0, 20.0, PEAK_NM_S_RAD];

pub(super) fn claims() -> Result<Vec<Claim>, Error> {
    Ok(vec![tolerant().map_err(refused)?, most_sensitive().map_err(refused)?, limit_cycles()?])
}

fn cases() -> Vec<(f64, f64, Fluid)> {
    let mut cases = Vec::new();
    for delay_s in DELAYS_S {
        for q1 in VISCOSITIES {
            cases.extend([DEAD, LAG].map(|fluid| (delay_s, q1, fluid)));
        }
    }
    cases
}

/// Whether the loop stays stable with each quantity alone off by `part`, up and down.
fn alone(closed: &Loop, part: f64) -> bool {
    let found = tolerances(closed);
    !found.is_empty()
        && found.iter().all(|tolerance| {
            let up = tolerance.upper.is_none_or(|limit| limit.factor > 1.0 + part);
            up && tolerance.lower.is_none_or(|limit| limit.factor < 1.0 - part)
        })
}

/// Whether it stays stable with all of them off by `part` together, in the worst of the corners.
fn together(nominal: &Loop, part: f64) -> Result<bool, LoopError> {
    let quantities =
        [Quantity::TorqueDelay, Quantity::FluidDelay, Quantity::BothGains, Quantity::Inertia, Quantity::Q1];
    for corner in 0..1_u32 << quantities.len() {
        let mut moved = *nominal;
        for (bit, quantity) in quantities.iter().enumerate() {
            let factor = if corner >> bit & 1 == 1 { 1.0 + part } else { 1.0 - part };
            moved = quantity.set(&moved, quantity.of(&moved) * factor)?;
        }
        if !curves::is_inside(&moved) {
            return Ok(false);
        }
    }
    Ok(true)
}

fn tolerant() -> Result<Claim, LoopError> {
    let cases = cases();
    let verdicts: Vec<[bool; 6]> = cases
        .par_iter()
        .map(|&(delay_s, q1, fluid)| {
            let closed = closed(delay_s, 0.2, q1, fluid)?;
            let [a, b, c] = DOZENS;
            let joint = |part| together(&closed, part);
            Ok([alone(&closed, a), alone(&closed, b), alone(&closed, c), joint(a)?, joint(b)?, joint(c)?])
        })
        .collect::<Result<_, LoopError>>()?;
    let count = |column: usize, chosen: &dyn Fn(&(f64, f64, Fluid)) -> bool| {
        let rows = cases.iter().zip(&verdicts).filter(|(case, _)| chosen(case));
        (rows.clone().filter(|(_, verdict)| verdict[column]).count(), rows.count())
    };
    let mut figures = Vec::new();
    for (k, part) in DOZENS.iter().enumerate() {
        let at = |column| {
            let text = |chosen: &dyn Fn(&(f64, f64, Fluid)) -> bool| {
                let (holds, of) = count(column, chosen);
                format!("{holds} of {of}")
            };
            let [at_ten, at_peak] = [10.0, PEAK_NM_S_RAD].map(|q| text(&move |case| case.1 == q));
            format!("{} places ({at_ten} at Q1 10, {at_peak} at Q1 {PEAK_NM_S_RAD})", text(&|_| true))
        };
        let percent = 100.0 * part;
        figures.push(format!("+-{percent:.0} %, one at a time: stable at {}", at(k)));
        figures.push(format!("+-{percent:.0} %, all together: stable at {}", at(k + 3)));
    }
    for (name, fluid) in [("dead time", DEAD), ("lag", LAG)] {
        figures
            .push(format!("L 5 ms, Q1 10, {name} 5 ms, limits alone: {}", limits(&closed(DELAY_S, 0.2, 10.0, fluid)?)));
    }
    let verdict = match count(1, &|_| true) {
        (0, _) => Verdict::DoesNotHold("at no place of the range".to_owned()),
        (holds, of) if holds == of => Verdict::Holds,
        (holds, of) => {
            let (lag, lags) = count(1, &|case| case.2 == LAG);
            let (dead, deads) = count(1, &|case| case.2 == DEAD);
            Verdict::HoldsOnly(format!(
                "+-36 % one at a time: at {holds} of {of} places ({lag} of {lags} with a lag, {dead} of {deads} with a dead \
                 time)"
            ))
        }
    };
    Ok(Claim {
        section: "VII",
        statement: "Variations of the model within several dozen percent do not destabilise the loop",
        test: "tolerance of L, L_Q or T_Q, K_P, K_D, both gains, J and Q1 alone, and corners of L, L_Q or T_Q, gains, J, Q1 \
               together; Q0 0.2",
        range: "L 1 to 10 ms times Q1 0.158, 5, 10, 20, 55 times dead time 5 and lag 5 ms; +-24, 36, 50 %".to_owned(),
        figures,
        verdict,
    })
}

/// `L x0.10..2.51, ...`
fn limits(closed: &Loop) -> String {
    let texts = tolerances(closed).into_iter().map(|tolerance| {
        let lower = tolerance.lower.map_or("any less".to_owned(), |limit| format!("{:.2}", limit.factor));
        let upper = tolerance.upper.map_or("any more".to_owned(), |limit| format!("{:.2}", limit.factor));
        format!("{} {lower} to {upper}", symbol(tolerance.quantity))
    });
    texts.collect::<Vec<_>>().join(", ")
}

fn symbol(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::TorqueDelay => "L",
        Quantity::FluidDelay => "L_Q or T_Q",
        Quantity::Kp => "K_P",
        Quantity::Kd => "K_D",
        Quantity::BothGains => "both gains",
        Quantity::Inertia => "J",
        Quantity::Q1 => "Q1",
    }
}

fn most_sensitive() -> Result<Claim, LoopError> {
    let mut found: Vec<(&str, usize)> = Vec::new();
    let mut of = 0;
    for (delay_s, q1, fluid) in cases() {
        let nearest = tolerances(&closed(delay_s, 0.2, q1, fluid)?).into_iter().filter_map(|tolerance| {
            let distance = |factor: f64| factor.ln().abs();
            let sides = [tolerance.lower, tolerance.upper].into_iter().flatten();
            let near = sides.map(|limit| distance(limit.factor)).min_by(f64::total_cmp)?;
            Some((tolerance.quantity, near))
        });
        let Some((quantity, _)) = nearest.min_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        of += 1;
        match found.iter_mut().find(|(name, _)| *name == symbol(quantity)) {
            Some((_, count)) => *count += 1,
            None => found.push((symbol(quantity), 1)),
        }
    }
    let fluid_delay = found.iter().find(|(name, _)| *name == "L_Q or T_Q").map_or(0, |(_, count)| *count);
    found.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let figures = found.iter().map(|(name, count)| format!("{name} is lost first at {count} of {of} stable places"));
    let verdict = match fluid_delay {
        0 => Verdict::DoesNotHold("some other quantity is always nearer to its limit".to_owned()),
        n if n == of => Verdict::Holds,
        n => Verdict::HoldsOnly(format!("L_Q or T_Q is nearest to its limit at {n} of {of} places")),
    };
    Ok(Claim {
        section: "VII",
        statement: "The loop is greatly affected by variation of the model, especially the lag time or time constant",
        test: "which quantity is nearest to its limit, as a factor",
        range: "as above, where the loop is stable".to_owned(),
        figures: figures.collect(),
        verdict,
    })
}

/// The nonlinear loop, by harmonic balance and in time: (L of the gains, L of the plant), ms.
const NONLINEAR_MS: [(f64, f64); 12] = [
    (2.0, 2.0),
    (3.0, 3.0),
    (5.0, 5.0),
    (8.0, 8.0),
    (10.0, 10.0),
    (2.0, 4.4),
    (2.0, 5.0),
    (2.0, 6.0),
    (3.0, 9.0),
    (5.0, 10.0),
    (5.0, 13.0),
    (5.0, 15.0),
];

fn limit_cycles() -> Result<Claim, Error> {
    let config = Config { brake_deadband_rad_s: 0.0, stale_time_s: 0.1, ..Config::default() };
    let mut figures = Vec::new();
    let (mut agree, mut of, mut free) = (0, 0, 0);
    let places = NONLINEAR_MS.map(|(gains_ms, plant_ms)| {
        let gains = NormalisedGains::PAPER.physical(INERTIA_KG_M2, gains_ms * 1e-3);
        let closed = Loop::new(plant(plant_ms * 1e-3, 0.0, 0.0, Fluid::None), gains).map_err(refused)?;
        let near_rad = 0.02 * (gains_ms / 5.0_f64).powi(2).max(1.0);
        let config = Config { near_rad: near_rad as f32, ..config };
        let models = cycles_by_model(&closed, &config, COULOMB_NM, Search::SERVO)?;
        Ok::<_, Error>((gains_ms, plant_ms, COULOMB_NM / gains.k_p_nm_rad, models))
    });
    for place in places {
        let (gains_ms, plant_ms, friction_error_rad, models) = place?;
        let mut lasting = Vec::new();
        for model in &models {
            let run_rad = model.simulated_amplitude_rad;
            let predicted: Vec<f64> =
                model.cycles.iter().filter(|cycle| cycle.stable).map(|cycle| cycle.amplitude_rad).collect();
            // Under the full damper the rotor creeps on long after the run; that is no cycle.
            let at_rest = run_rad < 0.1 * friction_error_rad;
            let matched = predicted.iter().any(|amplitude| (amplitude / run_rad - 1.0).abs() < 0.1);
            of += 1;
            agree += usize::from(if at_rest { predicted.is_empty() } else { matched });
            free += usize::from(plant_ms == gains_ms && at_rest && predicted.is_empty());
            if !at_rest || !predicted.is_empty() {
                let balance = predicted.first().map_or("none".to_owned(), |a| format!("{:.0}", a * 1e3));
                let run = if at_rest { "rest".to_owned() } else { format!("{:.0}", run_rad * 1e3) };
                lasting.push(format!("{} {balance}/{run}", model.model));
            }
        }
        if !lasting.is_empty() {
            let list = lasting.join(", ");
            figures.push(format!("gains for {gains_ms} ms, plant {plant_ms} ms: mrad by balance / in time: {list}"));
        }
    }
    figures.insert(0, format!("plant as the gains assume: no limit cycle at {free} of 40 places, by both"));
    figures.insert(
        1,
        format!("both methods agree at {agree} of {of} places (amplitude within 10 %, or rest: under 0.1 u)"),
    );
    Ok(Claim {
        section: "VII",
        statement: "The delay of the fluid does not destabilise the (nonlinear) loop",
        test: "limit cycles by harmonic balance, and what a 2 s run of the flashed law with the true speed is left with",
        range: "12 pairs of gains' L and plant's L times 8 delay models".to_owned(),
        figures,
        verdict: match free {
            40 => Verdict::HoldsOnly(
                "while the plant is about as fast as the gains assume; then under every model, \
                                      for a late damper still opposes the motion"
                    .to_owned(),
            ),
            0 => Verdict::DoesNotHold("limit cycles everywhere".to_owned()),
            n => Verdict::HoldsOnly(format!("at {n} of 40 places with the plant as the gains assume")),
        },
    })
}
