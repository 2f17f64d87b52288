//! Figs. 4, 6, 9 and 10: law, stable regions, friction.

use super::NamedFigure;
use crate::paper::case::{COULOMB_NM, DELAY_S};
use crate::paper::claims::{field_for_kv_mm, linear_plant, speeds_rad_s, torque_nm};
use crate::plot::{Figure, Mark, Panel, Series, Stroke};
use crate::stability::figure::stable_regions;
use crate::stability::region::{Window, stable_region};
use crate::stability::{Fluid, NormalisedGains};
use recording::Error;

/// The fluid's viscosity without a field, N m s/rad: Q0 of control.md section 6. Fig. 4 shows a slope at E = 0, the paper
/// does not say which.
const SLOPE_NM_S_RAD: f64 = 0.2;

pub(super) fn figures() -> Result<Vec<NamedFigure>, Error> {
    let named = |file, title: &str, panels| NamedFigure { file, figure: Figure { title: title.to_owned(), panels } };
    Ok(vec![
        named(
            "fig04.svg",
            "Fig. 4: torque at constant field, by (1); at 0 with the slope Q0 0.2 N m s/rad",
            vec![torque_at_constant_field()],
        ),
        named("fig06.svg", "Fig. 6: Q by (5), and the field it needs", viscosity().to_vec()),
        NamedFigure { file: "fig09.svg", figure: regions()? },
        named("fig10.svg", "Fig. 10: friction model, set-valued at rest; slope Q0 0.2 N m s/rad", vec![friction()]),
    ])
}

fn torque_at_constant_field() -> Panel {
    let strokes = [Stroke::Solid, Stroke::Dashed, Stroke::DashDot];
    let series = (0..=6).zip(strokes.into_iter().cycle()).map(|(k, stroke)| {
        let field = 0.5 * f64::from(k);
        // Under a field the paper averages over the speeds.
        let slope = if k == 0 { SLOPE_NM_S_RAD } else { 0.0 };
        let at = |speed: f64| (speed, slope.mul_add(speed, torque_nm(field) + COULOMB_NM));
        Series::new(&format!("{field:.1} kV/mm"), Mark::Line, [at(0.1), at(0.5)]).with(stroke)
    });
    Panel::new("speed (rad/s)", "torque (N m)", series.collect())
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

fn regions() -> Result<Figure, Error> {
    let plant = linear_plant(DELAY_S, 0.2, 10.0, Fluid::None);
    let models = [Fluid::None, Fluid::DeadTime { l_q_s: 0.005 }, Fluid::Lag { t_q_s: 0.005 }];
    let region = |fluid| stable_region(&linear_plant(DELAY_S, 0.2, 10.0, fluid), Window::SPECIFIED);
    let regions = models.map(|fluid| Ok((fluid, region(fluid).map_err(|error| Error::Usage(error.to_string()))?)));
    let regions = regions.into_iter().collect::<Result<Vec<_>, Error>>()?;
    Ok(stable_regions(&plant, &regions, NormalisedGains::PAPER))
}

fn friction() -> Panel {
    let end = SLOPE_NM_S_RAD.mul_add(0.5, COULOMB_NM);
    let points = [(-0.5, -end), (0.0, -COULOMB_NM), (0.0, COULOMB_NM), (0.5, end)];
    let name = "c of (1) and Q0, at rest anything between; the runs take c alone";
    Panel::new("speed (rad/s)", "friction torque (N m)", vec![Series::new(name, Mark::Line, points)])
}
