//! Figures: panels of lines, steps and points, each axis with its unit, written as SVG.

use std::ops::Range;
use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::{Error, output};

/// Width of a figure, pixels.
const WIDTH: u32 = 960;
/// Height of one panel, pixels.
const PANEL_HEIGHT: u32 = 260;
/// Height of the title, pixels.
const TITLE_HEIGHT: u32 = 40;
/// Colours that stay apart for colour-blind readers (Okabe and Ito).
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Straight from point to point.
    Line,
    /// Held from each point to the next.
    Step,
    /// A dot at each point.
    Points,
}

/// Points of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// In the legend; empty for none.
    pub name: String,
    /// How it is drawn.
    pub mark: Mark,
    /// In the units of the panel's axes; pairs that are not finite are left out.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// A series from columns.
    pub fn new(name: &str, mark: Mark, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let points = points.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        Self { name: name.to_owned(), mark, points }
    }
}

/// One coordinate system.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Quantity and unit, such as `time (s)`.
    pub x_label: String,
    /// Quantity and unit.
    pub y_label: String,
    /// What is drawn, first at the bottom.
    pub series: Vec<Series>,
}

impl Panel {
    /// A panel.
    pub fn new(x_label: &str, y_label: &str, series: Vec<Series>) -> Self {
        Self { x_label: x_label.to_owned(), y_label: y_label.to_owned(), series }
    }
}

/// Panels under one title.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Title.
    pub title: String,
    /// From top to bottom.
    pub panels: Vec<Panel>,
}

impl Figure {
    /// The figure as SVG text; the same figure gives the same bytes.
    ///
    /// # Errors
    /// What the plotting library says.
    pub fn to_svg(&self) -> Result<String, String> {
        let mut svg = String::new();
        let height = TITLE_HEIGHT + PANEL_HEIGHT * self.panels.len() as u32;
        let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        self.draw(&root).map_err(|error| error.to_string())?;
        drop(root);
        Ok(svg)
    }

    /// Writes the figure as an SVG file, whole or not at all.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn write(&self, file: &Path) -> Result<(), Error> {
        let svg = self.to_svg().map_err(|reason| Error::Output { file: file.to_path_buf(), reason })?;
        output::write(file, |to| std::io::Write::write_all(to, svg.as_bytes()))
    }

    fn draw(&self, root: &Area<'_>) -> Result<(), DrawingError<'_>> {
        root.fill(&WHITE)?;
        let (title, rest) = root.split_vertically(TITLE_HEIGHT);
        title.draw_text(&self.title, &("sans-serif", 20).into_text_style(&title), (16, 10))?;
        for (panel, area) in self.panels.iter().zip(rest.split_evenly((self.panels.len().max(1), 1))) {
            draw_panel(panel, &area)?;
        }
        root.present()
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type DrawingError<'a> = DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>;

fn draw_panel<'a>(panel: &Panel, area: &Area<'a>) -> Result<(), DrawingError<'a>> {
    let points = || panel.series.iter().flat_map(|series| &series.points);
    let (x, y) = (range(points().map(|point| point.0), 0.0), range(points().map(|point| point.1), 0.06));
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(24)
        .x_label_area_size(40)
        .y_label_area_size(84)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .x_desc(&panel.x_label)
        .y_desc(&panel.y_label)
        .x_label_formatter(&|value| tick_label(*value))
        .y_label_formatter(&|value| tick_label(*value))
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(225, 225, 225))
        .axis_desc_style(("sans-serif", 14))
        .label_style(("sans-serif", 12))
        .draw()?;
    for (series, colour) in panel.series.iter().zip(COLOURS.iter().cycle()) {
        let drawn = match series.mark {
            Mark::Points => {
                let dots = thin(&series.points).into_iter().map(|point| Circle::new(point, 2, colour.filled()));
                chart.draw_series(dots)?
            }
            Mark::Line => chart.draw_series(LineSeries::new(decimate(&series.points), colour))?,
            Mark::Step => chart.draw_series(LineSeries::new(decimate(&steps(&series.points)), colour))?,
        };
        if !series.name.is_empty() {
            let colour = *colour;
            drawn
                .label(&series.name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
        }
    }
    if panel.series.iter().any(|series| !series.name.is_empty()) {
        chart
            .configure_series_labels()
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(200, 200, 200))
            .label_font(("sans-serif", 12))
            .position(SeriesLabelPosition::UpperRight)
            .draw()?;
    }
    Ok(())
}

/// From the least to the largest value, with a share of it to spare; a constant gets room on both sides.
fn range(values: impl Iterator<Item = f64>, spare: f64) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    let width = if high > low { high - low } else { low.abs().max(1e-9) };
    let margin = if high > low { spare * width } else { 0.5 * width };
    low - margin..high + margin
}

/// Four significant digits, in powers of ten where plain digits would run long.
fn tick_label(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&size) {
        let decimals = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{value:.2e}")
    }
}

/// Each point held to the next one's abscissa.
fn steps(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let held = points.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    held.chain(points.last().copied()).collect()
}

/// Lowest and highest point of each pixel column: what the eye would see of all of them.
fn decimate(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let columns = 2 * WIDTH as usize;
    if points.len() <= 2 * columns {
        return points.to_vec();
    }
    let chunk = points.len().div_ceil(columns);
    let extremes = |chunk: &[(f64, f64)]| {
        let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let ends = [chunk.iter().min_by(by_value), chunk.iter().max_by(by_value)];
        let mut ends: Vec<(f64, f64)> = ends.into_iter().flatten().copied().collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends
    };
    points.chunks(chunk).flat_map(extremes).collect()
}

/// At most some thousands of dots, evenly chosen.
fn thin(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let most = 4000;
    points.iter().step_by(points.len().div_ceil(most).max(1)).copied().collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_long_recording_stays_small_and_keeps_its_extremes() {
        let points: Vec<(f64, f64)> =
            (0..1_000_000).map(|i| (f64::from(i), if i == 777_777 { 9.0 } else { 0.0 })).collect();
        assert!(decimate(&points).contains(&(777_777.0, 9.0)));
        let panel = Panel::new("time (s)", "position (rad)", vec![Series::new("recorded", Mark::Line, points)]);
        let svg = Figure { title: "long".to_owned(), panels: vec![panel] }.to_svg().unwrap();
        assert!(svg.len() < 500_000, "{} bytes", svg.len());
        assert!(svg.contains("position (rad)") && svg.contains("recorded"));
    }

    #[test]
    fn nothing_to_draw_is_an_empty_panel_not_a_panic() {
        let series = vec![Series::new("", Mark::Step, [(f64::NAN, 1.0)])];
        let figure = Figure { title: String::new(), panels: vec![Panel::new("x (s)", "y (1)", series)] };
        assert!(figure.to_svg().is_ok());
    }

    #[test]
    fn labels_are_short() {
        let labels = [0.0, 0.25, 12.5, 1e-5, 123_456.0, -3.0].map(tick_label);
        assert_eq!(labels, ["0", "0.25", "12.5", "1.00e-5", "1.23e5", "-3"]);
    }
}
