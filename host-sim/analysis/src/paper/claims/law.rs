//! Section III: the damper made linear, and equation (5).

use er_servo::{Config, FIELD_CEILING_KV_MM, Params, field_for_damping_kv_mm, viscosity_nm_s_rad};

use super::claim::{Claim, Verdict};

const A: f64 = 0.0704;
const B: f64 = 0.470;

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

pub(super) fn claims() -> Vec<Claim> {
    vec![linear(), unsaturated(), growing()]
}

fn linear() -> Claim {
    let limit = f64::from(FIELD_CEILING_KV_MM);
    let most_nm = torque_nm(limit);
    let departure = |q: f64| {
        let unsaturated = speeds_rad_s().filter(|speed| q * speed <= most_nm);
        let off = unsaturated.map(|speed| (torque_nm(field_for_kv_mm(q, speed).min(limit)) - q * speed).abs());
        off.fold(0.0, f64::max)
    };
    let figures = [1.0, 5.0, 10.0].map(|q| {
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
        range: "0 to 1.5 rad/s".to_owned(),
        figures: figures.to_vec(),
        verdict: Verdict::HoldsOnly(format!("while Q |w| is up to {most_nm:.4} N m, the torque of 3.5 kV/mm over c")),
    }
}

fn unsaturated() -> Claim {
    // The defaults are the paper's, and are checked by the library's own tests.
    let field = |speed: f64| {
        let params = Params::new(&Config::default()).ok()?;
        Some(f64::from(field_for_damping_kv_mm(&params, speed as f32)))
    };
    let fields = speeds_rad_s().filter_map(|speed| Some((speed, field(speed)?)));
    let peak = fields.fold((0.0, 0.0), |most, next| if next.1 > most.1 { next } else { most });
    let below = peak.1 < f64::from(FIELD_CEILING_KV_MM);
    Claim {
        section: "III-B",
        statement: "With Q of (5) the field stays under the limit of 3.5 kV/mm, so the viscosity is realised",
        test: "field of (4) with (5), as the flashed law computes it",
        range: "0 to 1.5 rad/s".to_owned(),
        figures: vec![format!("highest field {:.4} kV/mm, at {:.3} rad/s", peak.1, peak.0)],
        verdict: if below { Verdict::Holds } else { Verdict::DoesNotHold("the field saturates".to_owned()) },
    }
}

fn growing() -> Claim {
    let q = |speed: f64| f64::from(viscosity_nm_s_rad(speed as f32));
    let least = speeds_rad_s().fold((0.0, f64::INFINITY), |least, w| if q(w) < least.1 { (w, q(w)) } else { least });
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
        verdict: Verdict::HoldsOnly(format!(
            "below {:.2} rad/s; from there to 1.5 Q falls as the motor slows down",
            least.0
        )),
    }
}
