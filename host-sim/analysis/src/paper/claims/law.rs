//! Section III: the damper made linear, and equation (5).

use er_servo::{Config, FIELD_CEILING_KV_MM, Params, field_for_damping_kv_mm, viscosity_nm_s_rad};

use super::claim::{Claim, Verdict};
use crate::paper::case::{A, B, Case, Fluid};
use crate::paper::scan::{GAINS_DELAYS_S, STEPS_RAD};
use recording::Error;

/// Constant viscosities of Fig. 5, N m s/rad.
pub(in crate::paper) const VISCOSITIES: [f64; 3] = [1.0, 5.0, 10.0];

/// Equation (2) without c, N m.
pub(in crate::paper) fn torque_nm(field_kv_mm: f64) -> f64 {
    (A * field_kv_mm + B) * field_kv_mm
}

/// Equation (4) for a constant Q, kV/mm, before any limit.
pub(in crate::paper) fn field_for_kv_mm(viscosity_nm_s_rad: f64, speed_rad_s: f64) -> f64 {
    let half = B / (2.0 * A);
    (half * half + viscosity_nm_s_rad * speed_rad_s / A).sqrt() - half
}

/// Speeds from 0 to the 1.5 rad/s at which the damper is switched off.
pub(in crate::paper) fn speeds_rad_s() -> impl Iterator<Item = f64> {
    (0..=1500).map(|k| f64::from(k) * 1e-3)
}

pub(super) fn claims() -> Result<Vec<Claim>, Error> {
    Ok(vec![linear(), constant_saturates()?, unsaturated(), growing()])
}

fn linear() -> Claim {
    let limit = f64::from(FIELD_CEILING_KV_MM);
    let most_nm = torque_nm(limit);
    let off = |q: f64, speed: f64| (torque_nm(field_for_kv_mm(q, speed).min(limit)) - q * speed).abs();
    let departure = |q: f64| {
        let unsaturated = speeds_rad_s().filter(|speed| q * speed <= most_nm);
        unsaturated.map(|speed| off(q, speed)).fold(0.0, f64::max)
    };
    let places = || VISCOSITIES.into_iter().flat_map(|q| speeds_rad_s().map(move |speed| (q, speed)));
    let good = places().filter(|(q, speed)| off(*q, *speed) < 1e-9).count();
    let figures = VISCOSITIES.map(|q| {
        let worst = if departure(q) < 1e-9 { "below 1e-9".to_owned() } else { format!("{:.1e}", departure(q)) };
        let end = most_nm / q;
        let end =
            if end > 1.5 { "up to 1.5 rad/s".to_owned() } else { format!("up to {end:.4} rad/s, saturated above") };
        format!("Q {q} N m s/rad: off the line by {worst} N m, {end}")
    });
    Claim {
        section: "III-A, Fig. 5",
        statement: "The field of (4) makes the damper linear, good linearity for Q = 1, 5, 10 N m s/rad",
        test: "torque of (2) at the field of (4), held at 3.5 kV/mm, against Q |w| + c",
        range: "0 to 1.5 rad/s in steps of 1 mrad/s times the three Q".to_owned(),
        figures: figures.to_vec(),
        verdict: Verdict::of(
            good,
            places().count(),
            &format!("where Q |w| is up to {most_nm:.4} N m, the torque of 3.5 kV/mm over c"),
        ),
    }
}

/// Speeds of the steps, without a field, at which a constant Q asks for more than 3.5 kV/mm.
fn constant_saturates() -> Result<Claim, Error> {
    let most_nm = torque_nm(f64::from(FIELD_CEILING_KV_MM));
    let (mut saturated, mut of) = (0, 0);
    let mut figures = Vec::new();
    for gains_delay_s in GAINS_DELAYS_S {
        for step_rad in STEPS_RAD {
            let case = Case { fluid: Fluid::Off, gains_delay_s, plant_delay_s: gains_delay_s, step_rad, ..Case::PAPER };
            let rows = case.run()?;
            let fastest = rows.iter().map(|row| row.truth.velocity.abs()).fold(0.0, f64::max);
            if fastest == 0.0 {
                continue;
            }
            for q in VISCOSITIES {
                of += 1;
                saturated += usize::from(q * fastest > most_nm);
            }
            if (gains_delay_s, step_rad) == (Case::PAPER.gains_delay_s, Case::PAPER.step_rad) {
                let moving = || rows.iter().map(|row| row.truth.velocity.abs()).filter(|speed| *speed > 1e-3);
                let share = |q: f64| {
                    let over = moving().filter(|speed| q * speed > most_nm).count();
                    format!("Q {q} {:.0} %", 100.0 * over as f64 / moving().count().max(1) as f64)
                };
                let shares = VISCOSITIES.map(share).join(", ");
                figures.push(format!(
                    "30 degrees, L 5 ms: up to {fastest:.2} rad/s; over the limit for this part of the way: {shares}"
                ));
            }
        }
    }
    Ok(Claim {
        section: "III-B",
        statement: "A constant Q saturates the field of 3.5 kV/mm because of the speed in the transit",
        test: "fastest speed of a step without field times Q against the torque of 3.5 kV/mm",
        range: "L 1.5 to 10 ms times steps of 5.5 mrad to 1 rad times Q 1, 5, 10 N m s/rad".to_owned(),
        figures,
        verdict: Verdict::of(saturated, of, "the rest are small steps, too slow for it"),
    })
}

fn unsaturated() -> Claim {
    // The defaults are the paper's, and are checked by the library's own tests.
    let field = |speed: f64| {
        let params = Params::new(&Config::default()).ok()?;
        Some(f64::from(field_for_damping_kv_mm(&params, speed as f32)))
    };
    let fields = speeds_rad_s().filter_map(|speed| Some((speed, field(speed)?)));
    let peak = fields.fold((0.0, 0.0), |most, next| if next.1 > most.1 { next } else { most });
    let speeds = speeds_rad_s().count();
    let below = speeds_rad_s().filter_map(field).filter(|field| *field < f64::from(FIELD_CEILING_KV_MM)).count();
    Claim {
        section: "III-B",
        statement: "With Q of (5) the field stays under the limit of 3.5 kV/mm, so the viscosity is realised",
        test: "field of (4) with (5), as the flashed law computes it",
        range: "0 to 1.5 rad/s".to_owned(),
        figures: vec![format!("highest field {:.4} kV/mm, at {:.3} rad/s", peak.1, peak.0)],
        verdict: Verdict::of(below, speeds, ""),
    }
}

fn growing() -> Claim {
    let q = |speed: f64| f64::from(viscosity_nm_s_rad(speed as f32));
    let least = speeds_rad_s().fold((0.0, f64::INFINITY), |least, w| if q(w) < least.1 { (w, q(w)) } else { least });
    let grows = speeds_rad_s().zip(speeds_rad_s().skip(1)).filter(|(slow, fast)| q(*slow) > q(*fast)).count();
    Claim {
        section: "III-B, Fig. 6",
        statement: "Q is small at high speed and grows continuously as the motor slows down",
        test: "slope of (5), and the field on either side of 1.5 rad/s",
        range: "0 to 1.5 rad/s".to_owned(),
        figures: vec![
            format!(
                "Q {:.3} N m s/rad at rest, least {:.5} at {:.2} rad/s, {:.5} at 1.5",
                q(0.0),
                least.1,
                least.0,
                q(1.5)
            ),
            format!(
                "the field jumps from 0 to {:.3} kV/mm as the speed falls through 1.5 rad/s",
                field_for_kv_mm(q(1.5), 1.5)
            ),
        ],
        verdict: Verdict::of(
            grows,
            speeds_rad_s().count() - 1,
            &format!("below {:.2} rad/s; from there to 1.5 Q falls as the motor slows down", least.0),
        ),
    }
}
