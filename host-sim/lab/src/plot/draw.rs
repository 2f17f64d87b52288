//! A figure drawn with plotters.

use std::ops::Range;

use plotters::chart::{ChartBuilder, ChartContext, SeriesLabelPosition};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::types::RangedCoordf64;
use plotters::element::{Circle, PathElement};
use plotters::prelude::{Color, DrawingArea, IntoDrawingArea, IntoFont, RGBColor, SVGBackend, WHITE};

use super::ticks::{range, tick_label};
use super::{Figure, Panel, Series, Style, decimate, is_shown};

/// Units of the drawing in one pixel of the picture: plotters rounds to whole units, which shows in slow curves.
const UNITS_PER_PIXEL: u32 = 2;
const WIDTH: u32 = 900 * UNITS_PER_PIXEL;
const TITLE_HEIGHT: u32 = 34 * UNITS_PER_PIXEL;
const PANEL_HEIGHT: u32 = 230 * UNITS_PER_PIXEL;
const X_AXIS_HEIGHT: u32 = 46 * UNITS_PER_PIXEL;
const Y_AXIS_WIDTH: u32 = 76 * UNITS_PER_PIXEL;
const TEXT_SIZE: u32 = 13 * UNITS_PER_PIXEL;

/// Points of all curves and dots of all clouds of a figure: at some 10 and 100 bytes each they stay under 500 kB.
const MOST_CURVE_POINTS: usize = 18_000;
const MOST_DOTS: usize = 2_000;

/// Distinguishable with any colour vision, and in grey (Okabe and Ito, Color Universal Design, 2008).
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(70, 70, 70),
    RGBColor(230, 159, 0),
];
const FRAME: RGBColor = RGBColor(60, 60, 60);
const GRID: RGBColor = RGBColor(222, 222, 222);

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// What each series of the figure may use.
struct Budget {
    /// Columns of a curve, each of four points.
    columns: usize,
    /// Dots of a cloud.
    dots: usize,
}

impl Budget {
    fn of(figure: &Figure) -> Self {
        let series = || figure.panels.iter().flat_map(|panel| &panel.series);
        let clouds = series().filter(|series| series.style == Style::Scatter).count();
        let curves = series().count() - clouds;
        let columns = MOST_CURVE_POINTS / 4 / curves.max(1);
        Self { columns: columns.clamp(1, WIDTH as usize / 2), dots: (MOST_DOTS / clouds.max(1)).max(1) }
    }
}

pub(super) fn svg(figure: &Figure) -> Result<String, String> {
    let panels = u32::try_from(figure.panels.len().max(1)).map_err(|error| error.to_string())?;
    let height = TITLE_HEIGHT + panels * PANEL_HEIGHT + X_AXIS_HEIGHT;
    let mut text = String::new();
    draw(figure, SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area())
        .map_err(|error| format!("cannot draw `{}`: {error}", figure.title))?;
    let size =
        |units_per_pixel: u32| format!("width=\"{}\" height=\"{}\"", WIDTH / units_per_pixel, height / units_per_pixel);
    Ok(text.replacen(&size(1), &size(UNITS_PER_PIXEL), 1))
}

fn draw(figure: &Figure, area: Area<'_>) -> Result<(), Box<dyn std::error::Error>> {
    area.fill(&WHITE)?;
    let title = ("sans-serif", TEXT_SIZE + TEXT_SIZE / 4).into_font().color(&FRAME);
    let below = area.titled(&figure.title, title)?;
    let shown = figure.panels.iter().flat_map(|panel| &panel.series).flat_map(|series| &series.points);
    let x = range(shown.filter(|point| is_shown(point)).map(|point| point.0), 0.0);
    let budget = Budget::of(figure);
    let mut rest = below;
    for (index, panel) in figure.panels.iter().enumerate() {
        let is_last = index + 1 == figure.panels.len();
        let (top, remaining) = rest.split_vertically(if is_last { PANEL_HEIGHT + X_AXIS_HEIGHT } else { PANEL_HEIGHT });
        draw_panel(&top, panel, &x, is_last.then_some(&figure.x_label), &budget)?;
        rest = remaining;
    }
    area.present()?;
    Ok(())
}

/// Draws one panel; the x axis is labelled where `x_label` says how.
fn draw_panel(
    area: &Area<'_>,
    panel: &Panel,
    x: &Range<f64>,
    x_label: Option<&String>,
    budget: &Budget,
) -> Result<(), Box<dyn std::error::Error>> {
    let points = panel.series.iter().flat_map(|series| &series.points);
    let y = range(points.filter(|point| is_shown(point)).map(|point| point.1), 0.06);
    let mut chart = ChartBuilder::on(area)
        .margin_top(8 * UNITS_PER_PIXEL)
        .margin_right(18 * UNITS_PER_PIXEL)
        .set_label_area_size(plotters::chart::LabelAreaPosition::Left, Y_AXIS_WIDTH)
        .set_label_area_size(
            plotters::chart::LabelAreaPosition::Bottom,
            if x_label.is_some() { X_AXIS_HEIGHT } else { 0 },
        )
        .build_cartesian_2d(x.clone(), y.clone())?;
    let (x_span, y_span) = (x.end - x.start, y.end - y.start);
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(GRID)
        .axis_style(FRAME)
        .x_labels(10)
        .y_labels(6)
        .x_label_formatter(&|value| tick_label(*value, x_span))
        .y_label_formatter(&|value| tick_label(*value, y_span))
        .label_style(("sans-serif", TEXT_SIZE).into_font().color(&FRAME))
        .axis_desc_style(("sans-serif", TEXT_SIZE).into_font().color(&FRAME))
        .x_desc(x_label.map_or("", String::as_str))
        .y_desc(&panel.y_label)
        .draw()?;
    for (index, series) in panel.series.iter().enumerate() {
        draw_series(&mut chart, series, COLOURS[index % COLOURS.len()], x, &y, budget)?;
    }
    if panel.series.iter().any(|series| !series.label.is_empty()) {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.85))
            .border_style(GRID)
            .label_font(("sans-serif", TEXT_SIZE).into_font().color(&FRAME))
            .draw()?;
    }
    Ok(())
}

fn draw_series(
    chart: &mut Chart<'_, '_>,
    series: &Series,
    colour: RGBColor,
    x: &Range<f64>,
    y: &Range<f64>,
    budget: &Budget,
) -> Result<(), Box<dyn std::error::Error>> {
    let stroke = colour.stroke_width(UNITS_PER_PIXEL + UNITS_PER_PIXEL / 2);
    let dot = colour.mix(0.7).filled();
    let radius = 3 * UNITS_PER_PIXEL / 2;
    if series.style == Style::Scatter {
        let points = decimate::cloud(&series.points, x, y, budget.dots);
        chart.draw_series(points.into_iter().map(|point| Circle::new(point, radius, dot)))?;
    } else {
        let mut pieces = decimate::curve(&series.points, x, budget.columns);
        if series.style == Style::Step {
            pieces = pieces.iter().map(|piece| held(piece)).collect();
        }
        chart.draw_series(pieces.into_iter().map(|piece| PathElement::new(piece, stroke)))?;
    }
    if !series.label.is_empty() {
        // Drawing nothing again is how plotters names a series drawn in pieces.
        let named = chart.draw_series(std::iter::empty::<PathElement<(f64, f64)>>())?.label(&series.label);
        let length = 18 * UNITS_PER_PIXEL as i32;
        if series.style == Style::Scatter {
            named.legend(move |(x, y)| Circle::new((x + length / 2, y), radius, dot));
        } else {
            named.legend(move |(x, y)| PathElement::new(vec![(x, y), (x + length, y)], stroke));
        }
    }
    Ok(())
}

/// Points that hold each value until the next x.
fn held(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let corners = points.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    corners.chain(points.last().copied()).collect()
}
