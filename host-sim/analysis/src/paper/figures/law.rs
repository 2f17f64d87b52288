//! Figs. 3 to 6, 9 and 10: law, stable regions, friction.

use super::NamedFigure;
use crate::paper::case::{COULOMB_NM, DELAY_S};
use crate::paper::claims::{field_for_kv_mm, linear_plant, speeds_rad_s, torque_nm};
use crate::plot::{Figure, Mark, Panel, Series};
use crate::stability::region::{Window, stable_region};
use crate::stability::{Fluid, NormalisedGains};
use recording::Error;

/// Field limit, kV/mm.
const LIMIT_KV_MM: f64 = 3.5;

pub(super) fn figures() -> Result<Vec<NamedFigure>, Error> {
    let named = |file, title: &str, panels| NamedFigure { file, figure: Figure { title: title.to_owned(), panels } };
    Ok(vec![
        named("fig03.svg", "Fig. 3: strength of the fluid, as torque of the damper by (1)", vec![strength()]),
        named("fig04.svg", "Fig. 4: torque at constant field, by (1)", vec![torque_at_constant_field()]),
        named("fig05.svg", "Fig. 5: torque after linearisation, field of (4) up to 3.5 kV/mm", vec![linearised()]),
        named("fig06.svg", "Fig. 6: Q by (5), and the field it needs", viscosity().to_vec()),
        named("fig09.svg", "Fig. 9: stable regions, L 5 ms, Q0 0.2, Q1 10 N m s/rad", vec![regions()?]),
        named("fig10.svg", "Fig. 10: friction model, set-valued at rest", vec![friction()]),
    ])
}

fn strength() -> Panel {
    let points = (0..=350).map(|k| f64::from(k) * 0.01).map(|field| (field, torque_nm(field) + COULOMB_NM));
    Panel::new("field (kV/mm)", "torque (N m)", vec![Series::new("a E^2 + b E + c", Mark::Line, points)])
}

fn torque_at_constant_field() -> Panel {
    let series = (0..=6).map(|k| {
        let field = 0.5 * f64::from(k);
        let torque = torque_nm(field) + COULOMB_NM;
        Series::new(&format!("{field:.1} kV/mm"), Mark::Line, [(0.1, torque), (0.5, torque)])
    });
    Panel::new("speed (rad/s)", "torque (N m)", series.collect())
}

fn linearised() -> Panel {
    let series = [1.0, 5.0, 10.0].map(|q| {
        let field = move |speed: f64| field_for_kv_mm(q, speed).min(LIMIT_KV_MM);
        let points = speeds_rad_s().map(|speed| (speed, torque_nm(field(speed)) + COULOMB_NM));
        Series::new(&format!("Q {q} N m s/rad"), Mark::Line, points)
    });
    Panel::new("speed (rad/s)", "torque (N m)", series.to_vec())
}

fn viscosity() -> [Panel; 2] {
    let q = |speed: f64| f64::from(er_servo::viscosity_nm_s_rad(speed as f32));
    let points = speeds_rad_s().map(|speed| (speed, q(speed)));
    let fields = speeds_rad_s().map(|speed| (speed, field_for_kv_mm(q(speed), speed)));
    [
        Panel::new("speed (rad/s)", "Q (N m s/rad)", vec![Series::new("(5)", Mark::Line, points)]),
        Panel::new("speed (rad/s)", "field (kV/mm)", vec![Series::new("(4) with (5)", Mark::Line, fields)]),
    ]
}

fn regions() -> Result<Panel, Error> {
    let mut series = Vec::new();
    for (name, fluid) in [
        ("no delay", Fluid::None),
        ("dead time 5 ms", Fluid::DeadTime { l_q_s: 0.005 }),
        ("lag 5 ms", Fluid::Lag { t_q_s: 0.005 }),
    ] {
        let region = stable_region(&linear_plant(DELAY_S, 0.2, 10.0, fluid), Window::SPECIFIED)
            .map_err(|error| Error::Usage(error.to_string()))?;
        // One line with breaks, so that a model keeps one colour.
        let lines = region.outlines.iter().flat_map(|outline| {
            let closed = outline.iter().chain(outline.first()).map(|[kp, kd]| (*kp, *kd));
            closed.chain([(f64::NAN, f64::NAN)])
        });
        series.push(Series::new(name, Mark::Line, lines));
    }
    let NormalisedGains { kp, kd } = NormalisedGains::PAPER;
    series.push(Series::cross("gains of the paper", (kp, kd), (0.012, 0.06)));
    Ok(Panel::new("K_p* = K_P L^2 / J (1)", "K_d* = K_D L / J (1)", series))
}

fn friction() -> Panel {
    let points = [(-0.5, -COULOMB_NM), (0.0, -COULOMB_NM), (0.0, COULOMB_NM), (0.5, COULOMB_NM)];
    let name = "c of (1), at rest anything between";
    Panel::new("speed (rad/s)", "friction torque (N m)", vec![Series::new(name, Mark::Line, points)])
}
