//! Section V: stable regions of the linear loop.

use rayon::prelude::*;

use super::claim::{Claim, Verdict, refused};
use crate::paper::case::{DELAY_S, INERTIA_KG_M2};
use crate::stability::limits::{Margins, Quantity, margins, tolerance};
use crate::stability::region::{Window, stable_region};
use crate::stability::{Fluid, Gains, Loop, LoopError, NormalisedGains, Plant, argument, curves};
use recording::Error;

/// L of the range, s.
pub(super) const DELAYS_S: [f64; 10] = [0.001, 0.002, 0.003, 0.004, 0.005, 0.006, 0.007, 0.008, 0.009, 0.01];
/// The two delays of section V.
pub(super) const DEAD: Fluid = Fluid::DeadTime { l_q_s: 0.005 };
pub(super) const LAG: Fluid = Fluid::Lag { t_q_s: 0.005 };
/// Q at rest, the peak of (5), N m s/rad.
pub(super) const PEAK_NM_S_RAD: f64 = 55.147;

/// The machine with a torque delay, Q0, Q1 and a fluid.
pub(in crate::paper) fn plant(torque_delay_s: f64, q0_nm_s_rad: f64, q1_nm_s_rad: f64, fluid: Fluid) -> Plant {
    Plant { inertia_kg_m2: INERTIA_KG_M2, torque_delay_s, q0_nm_s_rad, q1_nm_s_rad, fluid }
}

/// That machine with the paper's gains for its delay.
pub(super) fn closed(torque_delay_s: f64, q0: f64, q1: f64, fluid: Fluid) -> Result<Loop, LoopError> {
    let gains = NormalisedGains::PAPER.physical(INERTIA_KG_M2, torque_delay_s);
    Loop::new(plant(torque_delay_s, q0, q1, fluid), gains)
}

pub(super) fn claims() -> Result<Vec<Claim>, Error> {
    [first_quadrant, smaller, inside, little_affected].into_par_iter().map(|test| test().map_err(refused)).collect()
}

fn first_quadrant() -> Result<Claim, LoopError> {
    // Points left of and below the first quadrant, by the argument principle.
    let mut stable = 0;
    let mut example = None;
    let grid: Vec<(f64, f64)> =
        (1..=20).flat_map(|kp| (1..=20).map(move |kd| (0.004 * f64::from(kp), -0.04 * f64::from(kd)))).collect();
    for &(kp, kd) in &grid {
        let gains = NormalisedGains { kp, kd }.physical(INERTIA_KG_M2, DELAY_S);
        let count = argument::unstable_roots(&Loop::new(plant(DELAY_S, 0.2, 10.0, DEAD), gains)?);
        if count == Some(0) {
            stable += 1;
            // The furthest from the quadrant.
            if example.is_none_or(|(_, far)| kd < far) {
                example = Some((kp, kd));
            }
        }
    }
    let figures = vec![
        format!("L 5 ms, Q0 0.2, Q1 10, dead time 5 ms: stable at {stable} of {} points with K_d* below 0", grid.len()),
        example.map_or_else(String::new, |(kp, kd)| format!("for example at ({kp:.3}, {kd:.2})")),
    ];
    let verdict = Verdict::of(
        grid.len() - stable,
        grid.len(),
        "a convention, not a theorem: the rule is of polynomials, and viscosity damps where K_D does not",
    );
    Ok(Claim {
        section: "V-C",
        statement: "Stability needs all coefficients of the denominator positive, so the regions lie in the first \
                    quadrant",
        test: "roots counted by the argument principle at points with K_d* below 0",
        range: "K_p* 0.004 to 0.08, K_d* -0.04 to -0.8".to_owned(),
        figures,
        verdict,
    })
}

fn smaller() -> Result<Claim, LoopError> {
    let areas: Vec<[f64; 3]> = DELAYS_S
        .into_par_iter()
        .map(|delay_s| {
            let area = |fluid| Ok(stable_region(&plant(delay_s, 0.2, 10.0, fluid), Window::SPECIFIED)?.area());
            Ok([area(Fluid::None)?, area(DEAD)?, area(LAG)?])
        })
        .collect::<Result<_, LoopError>>()?;
    let smaller = areas.iter().filter(|[none, dead, lag]| dead < none && lag < none).count();
    let figures = DELAYS_S.iter().zip(&areas).map(|(delay_s, [none, dead, lag])| {
        format!("L {} ms: {none:.3} none, {dead:.3} dead 5 ms, {lag:.3} lag 5 ms", delay_s * 1e3)
    });
    let verdict = Verdict::of(smaller, areas.len(), "");
    Ok(Claim {
        section: "V-C, Fig. 9",
        statement: "If Q is variable and has a time delay, the stable regions become smaller",
        test: "area of the region within K_p* 0 to 1.6, K_d* 0 to 2.2, Q0 0.2, Q1 10",
        range: "L 1 to 10 ms".to_owned(),
        figures: figures.collect(),
        verdict,
    })
}

/// Largest Q1 up to 400 that keeps the paper's gains stable, Q0 = 0; none if all do.
fn largest_q1(delay_s: f64, fluid: Fluid) -> Result<Option<f64>, LoopError> {
    let limit = tolerance(&closed(delay_s, 0.0, 1.0, fluid)?, Quantity::Q1).upper;
    Ok(limit.map(|limit| limit.value).filter(|q1| *q1 <= 400.0))
}

/// Limits of Q1 alone, in words.
fn q1_limits() -> Result<[String; 2], LoopError> {
    let mut limits = Vec::new();
    let mut unlimited = 0;
    for delay_s in DELAYS_S {
        let text = match largest_q1(delay_s, DEAD)? {
            Some(q1) => format!("{q1:.1}"),
            None => "over 400".to_owned(),
        };
        limits.push(format!("{text} (L {} ms)", delay_s * 1e3));
        unlimited += usize::from(largest_q1(delay_s, LAG)?.is_none());
    }
    Ok([
        format!("Q0 0, dead time 5 ms: outside for Q1 above {}", limits.join(", ")),
        format!("Q0 0, lag 5 ms: inside for any Q1 up to 400 for {unlimited} of {} L", DELAYS_S.len()),
    ])
}

fn inside() -> Result<Claim, LoopError> {
    let mut figures = Vec::new();
    let mut inside = [0; 4];
    for delay_s in DELAYS_S {
        for (count, (q1, fluid)) in
            inside.iter_mut().zip([(10.0, DEAD), (10.0, LAG), (PEAK_NM_S_RAD, DEAD), (PEAK_NM_S_RAD, LAG)])
        {
            *count += usize::from(curves::is_inside(&closed(delay_s, 0.2, q1, fluid)?));
        }
    }
    let of = DELAYS_S.len();
    figures.push(format!("Q1 10: inside for {} of {of} L with dead time, {} with lag", inside[0], inside[1]));
    figures.push(format!(
        "Q1 {PEAK_NM_S_RAD}, the peak of (5): inside for {} of {of} L with dead time, {} with lag",
        inside[2], inside[3]
    ));
    figures.extend(q1_limits()?);
    let verdict = Verdict::of(
        inside.iter().sum(),
        4 * of,
        "with a lag, or while Q1 stays at the 10 N m s/rad of the figure; the peak of (5), 55, leaves the region with a dead \
         time of 5 ms",
    );
    Ok(Claim {
        section: "V-C, Fig. 9",
        statement: "The gains (0.0800, 0.464) are somewhat inside the stable regions",
        test: "boundary curves (11) and (13); limit of Q1 alone",
        range: "L 1 to 10 ms times Q1 10 and the peak of (5)".to_owned(),
        figures,
        verdict,
    })
}

fn in_words(found: &Margins) -> String {
    let number = |value: Option<f64>, decimals: usize| value.map_or("none".to_owned(), |v| format!("{v:.decimals$}"));
    format!(
        "gain margin {}, phase margin {} degrees, delay margin {} times L",
        number(found.gain, 2),
        number(found.phase_deg, 1),
        number(found.delay_factor, 2)
    )
}

fn little_affected() -> Result<Claim, LoopError> {
    let mut figures = Vec::new();
    let (mut little, mut of) = (0, 0);
    let named = [
        ("Q = 0", 0.0, Fluid::None),
        ("Q1 10, no delay", 10.0, Fluid::None),
        ("Q1 10, dead 5 ms", 10.0, DEAD),
        ("Q1 10, lag 5 ms", 10.0, LAG),
    ];
    for delay_s in DELAYS_S {
        let mut gain_margins = Vec::new();
        for (name, q1, fluid) in named {
            let q0 = if q1 == 0.0 { 0.0 } else { 0.2 };
            let found = margins(&closed(delay_s, q0, q1, fluid)?);
            if let Some(found) = found.as_ref().filter(|_| delay_s == DELAY_S) {
                figures.push(format!("L 5 ms, {name}: {}", in_words(found)));
            }
            gain_margins.push(found.and_then(|found| found.gain).unwrap_or(0.0));
        }
        if let [_, prompt, delayed @ ..] = &gain_margins[..] {
            of += delayed.len();
            little += delayed.iter().filter(|gain| **gain > 0.7 * prompt).count();
        }
    }
    let critical = std::f64::consts::FRAC_PI_2 * INERTIA_KG_M2 / 0.005;
    let alone = Loop::new(plant(DELAY_S, 0.0, 1.05 * critical, DEAD), Gains { k_p_nm_rad: 1e-3, k_d_nm_s_rad: 0.0 })?;
    figures.push(format!(
        "a dead time of 5 ms makes the damper of (10) unstable by itself above Q1 = pi J / 2 L_Q = {critical:.1} N m s/rad \
         ({} at 5 % more)",
        if curves::is_inside(&alone) { "not confirmed" } else { "confirmed" }
    ));
    Ok(Claim {
        section: "V-C",
        statement: "The delay of Q does not greatly affect the stability",
        test: "margins of the loop opened at the control torque: more than 70 % of the gain margin with Q1 10 at once is left \
               with its delay",
        range: "L 1 to 10 ms times dead time 5 and lag 5 ms, Q0 0.2, Q1 10".to_owned(),
        figures,
        verdict: Verdict::of(little, of, "stable it stays, at Q1 10"),
    })
}
