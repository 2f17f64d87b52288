//! The stable regions in the plane of the normalised gains, as Fig. 9 of the paper: closed curves in its three styles of
//! line, which the panels of [`crate::plot`], made for long recordings, do not draw.

use plotters::prelude::*;
use std::error::Error;

use crate::stability::Fluid;
use crate::stability::analysis::Analysis;
use crate::stability::region::{Point, Region};

/// An SVG of the three regions' outlines and the point of the gains.
// Over 40 lines: one picture, in the order in which it is drawn.
pub(super) fn draw(analysis: &Analysis, regions: &[Region]) -> Result<String, Box<dyn Error>> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (720, 540)).into_drawing_area();
        area.fill(&WHITE)?;
        let plant = &analysis.plant;
        let title = format!(
            "Stable regions: L {:.2} ms, J {} kg m2, Q0 {}, Q1 {} N m s/rad",
            plant.torque_delay_s * 1e3,
            plant.inertia_kg_m2,
            plant.q0_nm_s_rad,
            plant.q1_nm_s_rad
        );
        let (kp, kd) = (extent(analysis, regions, 0), extent(analysis, regions, 1));
        let mut chart = ChartBuilder::on(&area)
            .caption(title, ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(54)
            .build_cartesian_2d(0.0..kp, 0.0..kd)?;
        chart.configure_mesh().x_desc("K_p* = K_P L^2 / J (1)").y_desc("K_d* = K_D L / J (1)").draw()?;
        for ((region, known), colour) in regions.iter().zip(&analysis.regions).zip([BLACK, BLUE, RED]) {
            let style = colour.stroke_width(2);
            for (n, outline) in region.outlines.iter().enumerate() {
                let closed = outline.iter().chain(outline.first()).map(|&[kp, kd]| (kp, kd));
                // The line of Fig. 9: dotted without delay, solid for the dead time, broken for the lag.
                let series = match known.fluid {
                    Fluid::None => chart.draw_series(DashedLineSeries::new(closed, 2, 4, style))?,
                    Fluid::DeadTime { .. } => chart.draw_series(LineSeries::new(closed, style))?,
                    Fluid::Lag { .. } => chart.draw_series(DashedLineSeries::new(closed, 9, 4, style))?,
                };
                if n == 0 {
                    let label = format!("{}, area {:.3}", name(known.fluid), known.area);
                    series.label(label).legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
                }
            }
        }
        let point = (analysis.normalised_gains.kp, analysis.normalised_gains.kd);
        chart
            .draw_series([Circle::new(point, 5, BLACK.filled())])?
            .label(format!("gains ({:.4}, {:.4})", point.0, point.1))
            .legend(|(x, y)| Circle::new((x + 9, y), 4, BLACK.filled()));
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .border_style(BLACK)
            .background_style(WHITE)
            .draw()?;
        area.present()?;
    }
    Ok(svg)
}

/// Upper end of an axis: a little over whatever is drawn.
fn extent(analysis: &Analysis, regions: &[Region], axis: usize) -> f64 {
    let gains: Point = [analysis.normalised_gains.kp, analysis.normalised_gains.kd];
    let drawn = regions.iter().flat_map(|region| region.outlines.iter().flatten()).map(|point| point[axis]);
    1.05 * drawn.fold(gains[axis], f64::max).max(0.1)
}

fn name(fluid: Fluid) -> String {
    match fluid {
        Fluid::None => "no delay".to_owned(),
        Fluid::DeadTime { l_q_s } => format!("dead time {:.2} ms", l_q_s * 1e3),
        Fluid::Lag { t_q_s } => format!("lag {:.2} ms", t_q_s * 1e3),
    }
}
