//! Claims of section VI that need runs of their own.

use rayon::prelude::*;

use super::super::claim::{Claim, Verdict};
use super::super::law::torque_nm;
use crate::paper::case::{COULOMB_NM, Case, Fluid, Speed};
use crate::paper::scan::GAINS_DELAYS_S;
use crate::simulate::Row;
use recording::Error;

/// L of the range with the plant as the gains assume.
fn at(delay_s: f64, fluid: Fluid) -> Case {
    Case { fluid, gains_delay_s: delay_s, plant_delay_s: delay_s, ..Case::PAPER }
}

/// How far the models (but Q dead 50 ms, which differs whatever the friction) are apart after 30 degrees: spread of the
/// rest positions, rad, and the most dips, for each L.
fn spread(coulomb_nm: f64) -> Result<Vec<(f64, usize)>, Error> {
    let of_one = |delay_s: &f64| {
        let (mut low, mut high, mut dips) = (f64::INFINITY, f64::NEG_INFINITY, 0);
        for fluid in Fluid::ALL.into_iter().filter(|fluid| *fluid != Fluid::QDead50) {
            let case = Case { coulomb_nm, ..at(*delay_s, fluid) };
            let rows = case.run()?;
            let rest_rad = rows.last().map_or(0.0, |row| row.truth.position);
            (low, high) = (rest_rad.min(low), rest_rad.max(high));
            dips = dips.max(case.response(&rows).map_or(0, |response| response.dips));
        }
        Ok((high - low, dips))
    };
    GAINS_DELAYS_S.par_iter().map(of_one).collect()
}

pub(super) fn friction_shows_the_differences() -> Result<Claim, Error> {
    let (without, with) = (spread(0.0)?, spread(COULOMB_NM)?);
    let mut figures = Vec::new();
    let (mut narrower, mut calmer) = (0, 0);
    for ((delay_s, without), with) in GAINS_DELAYS_S.iter().zip(&without).zip(&with) {
        narrower += usize::from(2.0 * without.0 < with.0);
        calmer += usize::from(without.1 + 2 <= with.1);
        figures.push(format!(
            "L {} ms: rest positions spread {:.3} mrad without friction, {:.3} with; at most {} and {} dips",
            delay_s * 1e3,
            without.0 * 1e3,
            with.0 * 1e3,
            without.1,
            with.1
        ));
    }
    let of = GAINS_DELAYS_S.len();
    figures.push(format!("friction doubles the spread at {narrower} of {of} L, adds 2 dips or more at {calmer}"));
    let verdict = match narrower.max(calmer) {
        n if n == of && narrower == calmer => Verdict::Holds,
        n if 2 * n < of => Verdict::DoesNotHold(
            "with the nonlinear law in the loop the models differ about as much without friction; the linear loop (9) has \
             no E to delay"
                .to_owned(),
        ),
        _ => Verdict::HoldsOnly(format!("at {narrower} of {of} L for the rest position, at {calmer} for the vibration")),
    };
    Ok(Claim {
        section: "VI-A",
        statement: "Without friction the simulation hardly vibrates, so the delay models are hard to tell apart",
        test: "30 degree step of all models (but Q dead 50) with friction 0 and 0.763 N m: spread of the rest positions, \
               most dips",
        range: "L 1.5 to 10 ms, plant as the gains assume, true speed".to_owned(),
        figures,
        verdict,
    })
}

/// Share of the commanded torque of the damper that acts while the rotor arrives: from the last time it is faster than
/// 1.5 rad/s to the largest command, under a lag of the field.
fn share_on_arrival(rows: &[Row], lag_s: f64, period_s: f64) -> Option<f64> {
    let keep = (-period_s / lag_s).exp();
    let start = rows.iter().rposition(|row| row.truth.velocity.abs() > 1.5)?;
    let arrival = rows.get(start + 1..)?;
    let command_kv_mm = |row: &Row| f64::from(row.outputs.field_kv_mm);
    let (last, _) = arrival.iter().enumerate().max_by(|a, b| command_kv_mm(a.1).total_cmp(&command_kv_mm(b.1)))?;
    let (mut acting_kv_mm, mut acted, mut commanded) = (0.0, 0.0, 0.0);
    for command_kv_mm in arrival.iter().take(last + 1).map(command_kv_mm) {
        acting_kv_mm = command_kv_mm + (acting_kv_mm - command_kv_mm) * keep;
        acted += torque_nm(acting_kv_mm);
        commanded += torque_nm(command_kv_mm);
    }
    Some(acted / commanded)
}

pub(super) fn field_comes_short() -> Result<Claim, Error> {
    let mut figures = Vec::new();
    let (mut short, mut of) = (0, 0);
    for delay_s in GAINS_DELAYS_S {
        let case = at(delay_s, Fluid::ELag5);
        let period_s = f64::from(case.config().period_s);
        let Some(share) = share_on_arrival(&case.run()?, 0.005, period_s) else { continue };
        of += 1;
        short += usize::from(share < 0.9);
        figures.push(format!("L {} ms: {:.0} % of the commanded torque acts", delay_s * 1e3, 100.0 * share));
    }
    Ok(Claim {
        section: "VI-E",
        statement: "The slow field is insufficient in the vicinity of the reference",
        test: "torque of the lagged field over the commanded one, from the last 1.5 rad/s until the command peaks; short \
               below 90 %",
        range: "30 degree step, L 1.5 to 10 ms, plant as the gains assume, true speed".to_owned(),
        figures,
        verdict: match short {
            0 => Verdict::DoesNotHold("the field keeps up".to_owned()),
            n if n == of => Verdict::Holds,
            n => Verdict::HoldsOnly(format!("at {n} of {of} L")),
        },
    })
}

/// Models of E with a delay.
const FIELD_MODELS: [Fluid; 3] = [Fluid::EDead5, Fluid::ELag5, Fluid::EDead2Lag3];

/// Rest position of a 30 degree step, u.
fn residual_u(delay_s: f64, fluid: Fluid, hold: bool, speed: Speed) -> Result<f64, Error> {
    let case = Case { hold, speed, ..at(delay_s, fluid) };
    Ok(case.response(&case.run()?).map_or(0.0, |response| response.residual_u))
}

/// Places at which a delayed field holds half a u more than friction does by itself.
fn stuck(hold: bool, speed: Speed) -> Result<usize, Error> {
    let mut count = 0;
    for delay_s in GAINS_DELAYS_S {
        for fluid in FIELD_MODELS {
            count += usize::from(residual_u(delay_s, fluid, hold, speed)?.abs() > 1.5);
        }
    }
    Ok(count)
}

pub(super) fn cannot_return() -> Result<Claim, Error> {
    let mut figures = Vec::new();
    for (brake, hold) in [("strict", false), ("holding", true)] {
        let list = Fluid::ALL
            .into_par_iter()
            .map(|fluid| Ok(format!("{} {:.2}", fluid.name(), residual_u(0.005, fluid, hold, Speed::True)?)));
        let list = list.collect::<Result<Vec<_>, Error>>()?.join(", ");
        figures.push(format!("30 degrees, L 5 ms, {brake} brake, residual in u: {list}"));
    }
    let (strict, holding) = (stuck(false, Speed::True)?, stuck(true, Speed::True)?);
    let (strict_counts, holding_counts) = (stuck(false, Speed::Counts)?, stuck(true, Speed::Counts)?);
    let of = GAINS_DELAYS_S.len() * FIELD_MODELS.len();
    figures.push(format!("delayed E, residual over 1.5 u: at {strict} of {of} places strict, {holding} with hold"));
    figures.push(format!("speed from counts: {strict_counts} strict, {holding_counts} with hold"));
    let verdict = match (strict, holding) {
        (0, 0) => Verdict::DoesNotHold("nothing but dry friction holds the rotor".to_owned()),
        (0, n) => Verdict::HoldsOnly(format!(
            "if the brake also holds at w = 0: then at {n} of {of} places a delayed E sticks, near 2 u; with the strict \
             brake at none"
        )),
        (n, _) if n == of => Verdict::Holds,
        (n, _) => Verdict::HoldsOnly(format!("at {n} of {of} places with the strict brake")),
    };
    Ok(Claim {
        section: "VI-E, Fig. 16",
        statement: "The large field leaves a large friction, and the angle cannot return to the reference",
        test: "rest position of a 30 degree step in u = c / K_P, what dry friction holds; strict and holding brake",
        range: "L 1.5 to 10 ms times E dead 5, E lag 5, E 2 + 3 ms, plant as the gains assume".to_owned(),
        figures,
        verdict,
    })
}

pub(super) fn experiment() -> Claim {
    Claim {
        section: "VI-F, VII, Figs. 11, 12 to 19",
        statement: "E dead 2 + lag 3 ms is the closest to the experiment, E lag 5 ms the furthest from it",
        test: "none",
        range: "none".to_owned(),
        figures: vec!["Figs. 17 to 19 are drawn from the simulation alone".to_owned()],
        verdict: Verdict::NotTestable(
            "the measured curves and the measured friction of Fig. 10 are not available".to_owned(),
        ),
    }
}
