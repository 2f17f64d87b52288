//! The stable regions in the plane of the normalised gains: Fig. 9 of the paper, in its styles of line.

use super::region::Region;
use super::{Fluid, NormalisedGains, Plant};
use crate::plot::{Figure, Mark, Panel, Series, Stroke};

/// The regions' outlines, dotted without delay, solid for a dead time, dot-dashed for a lag, and the point of the gains.
/// `plant` is the one they are of, whatever its fluid.
#[must_use]
pub fn stable_regions(plant: &Plant, regions: &[(Fluid, Region)], gains: NormalisedGains) -> Figure {
    let mut series = Vec::new();
    for (fluid, region) in regions {
        // One line with breaks, so that a model keeps one colour.
        let lines = region.outlines.iter().flat_map(|outline| {
            let closed = outline.iter().chain(outline.first()).map(|[kp, kd]| (*kp, *kd));
            closed.chain([(f64::NAN, f64::NAN)])
        });
        let (name, stroke) = match fluid {
            Fluid::None => ("no delay".to_owned(), Stroke::Dotted),
            Fluid::DeadTime { l_q_s } => (format!("dead time {} ms", l_q_s * 1e3), Stroke::Solid),
            Fluid::Lag { t_q_s } => (format!("lag {} ms", t_q_s * 1e3), Stroke::DashDot),
        };
        let name = format!("{name}, area {:.3}", region.area());
        series.push(Series::new(&name, Mark::Line, lines).with(stroke));
    }
    let NormalisedGains { kp, kd } = gains;
    series.push(Series::cross(&format!("gains ({kp:.4}, {kd:.4})"), (kp, kd), (0.012, 0.06)));
    let title = format!(
        "Fig. 9: stable regions, L {:.2} ms, J {} kg m2, Q0 {}, Q1 {} N m s/rad",
        plant.torque_delay_s * 1e3,
        plant.inertia_kg_m2,
        plant.q0_nm_s_rad,
        plant.q1_nm_s_rad
    );
    Figure { title, panels: vec![Panel::new("K_p* = K_P L^2 / J (1)", "K_d* = K_D L / J (1)", series)] }
}
