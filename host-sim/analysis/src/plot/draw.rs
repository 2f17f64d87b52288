//! A figure drawn with plotters.

use std::ops::Range;

use plotters::chart::{ChartBuilder, ChartContext, LabelAreaPosition};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::types::RangedCoordf64;
use plotters::element::{Circle, PathElement, Text};
use plotters::prelude::{Color, DrawingArea, IntoDrawingArea, IntoFont, RGBColor, SVGBackend, ShapeStyle, WHITE};
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::dashes::broken;
use super::decimate;
use super::figure::{Figure, Ink, Mark, Panel, Series, is_shown};
use super::ticks::{range, tick_label};

/// Units of the drawing in one pixel of the picture: plotters rounds to whole units, which shows in slow curves.
const UNITS_PER_PIXEL: u32 = 2;
const WIDTH: u32 = 900 * UNITS_PER_PIXEL;
const TITLE_HEIGHT: u32 = 34 * UNITS_PER_PIXEL;
const PANEL_HEIGHT: u32 = 230 * UNITS_PER_PIXEL;
const LEGEND_HEIGHT: u32 = 20 * UNITS_PER_PIXEL;
const X_AXIS_HEIGHT: u32 = 42 * UNITS_PER_PIXEL;
const Y_AXIS_WIDTH: u32 = 74 * UNITS_PER_PIXEL;
const MARGIN: u32 = 8 * UNITS_PER_PIXEL;
const TEXT_SIZE: u32 = 13 * UNITS_PER_PIXEL;
const DOT_RADIUS: u32 = 3 * UNITS_PER_PIXEL / 2;
/// Half the width of the ends of an error bar.
const BAR_END: f64 = 3.0 * UNITS_PER_PIXEL as f64;

/// Points of all curves and dots of all clouds of a figure: at some 10 and 100 bytes each they stay under 500 kB.
const MOST_CURVE_POINTS: usize = 18_000;
const MOST_DOTS: usize = 2_000;

/// Distinguishable with any colour vision, and in grey (Okabe and Ito, Color Universal Design, 2008).
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(70, 70, 70),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
/// Of the same, for what has one colour in every figure: grey, vermilion, blue.
const RECORDED: RGBColor = RGBColor(70, 70, 70);
const NOMINAL: RGBColor = RGBColor(213, 94, 0);
const IMPROVED: RGBColor = RGBColor(0, 114, 178);
const FRAME: RGBColor = RGBColor(60, 60, 60);
const GRID: RGBColor = RGBColor(222, 222, 222);

/// The series of a panel with their colours.
fn inked(panel: &Panel) -> impl Iterator<Item = (&Series, RGBColor)> {
    panel.series.iter().zip(COLOURS.into_iter().cycle()).map(|(series, by_place)| {
        let colour = match series.ink {
            Ink::ByPlace => by_place,
            Ink::Recorded => RECORDED,
            Ink::Nominal => NOMINAL,
            Ink::Improved => IMPROVED,
        };
        (series, colour)
    })
}

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
        let clouds = series().filter(|series| series.mark == Mark::Points).count();
        let bars = series().filter(|series| series.mark == Mark::Bars).count();
        let curves = series().count() - clouds - bars;
        let columns = MOST_CURVE_POINTS / 4 / curves.max(1);
        Self { columns: columns.clamp(1, WIDTH as usize / 2), dots: (MOST_DOTS / clouds.max(1)).max(1) }
    }
}

pub(super) fn svg(figure: &Figure) -> Result<String, String> {
    let panels = u32::try_from(figure.panels.len().max(1)).map_err(|error| error.to_string())?;
    let x_axes = x_axis_groups(figure).count().max(1) as u32;
    let height = TITLE_HEIGHT + panels * PANEL_HEIGHT + x_axes * X_AXIS_HEIGHT;
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
    let budget = Budget::of(figure);
    let mut rest = below;
    for group in x_axis_groups(figure) {
        let shown = group.iter().flat_map(|panel| &panel.series).flat_map(|series| &series.points);
        let x = range(shown.filter(|point| is_shown(point)).map(|point| point.0), 0.0);
        for (index, panel) in group.iter().enumerate() {
            let has_x_axis = index + 1 == group.len();
            let height = PANEL_HEIGHT + if has_x_axis { X_AXIS_HEIGHT } else { 0 };
            let (top, remaining) = rest.split_vertically(height);
            draw_panel(&top, panel, &x, has_x_axis, &budget)?;
            rest = remaining;
        }
    }
    area.present()?;
    Ok(())
}

/// Neighbouring panels over the same x axis, which the last of them carries.
fn x_axis_groups(figure: &Figure) -> impl Iterator<Item = &[Panel]> {
    figure.panels.chunk_by(|one, next| one.x_label == next.x_label)
}

/// Draws one panel; numbers and label of the x axis are left to a panel below where it does not carry them.
fn draw_panel(
    area: &Area<'_>,
    panel: &Panel,
    x: &Range<f64>,
    has_x_axis: bool,
    budget: &Budget,
) -> Result<(), Box<dyn std::error::Error>> {
    let points = panel.series.iter().flat_map(|series| &series.points);
    let y = range(points.filter(|point| is_shown(point)).map(|point| point.1), 0.06);
    let area = draw_legend(area, panel)?;
    let mut chart = ChartBuilder::on(&area)
        .margin_left(MARGIN)
        .margin_right(2 * MARGIN)
        .margin_bottom(MARGIN)
        .set_label_area_size(LabelAreaPosition::Left, Y_AXIS_WIDTH)
        .set_label_area_size(LabelAreaPosition::Bottom, if has_x_axis { X_AXIS_HEIGHT } else { 0 })
        .build_cartesian_2d(x.clone(), y.clone())?;
    let (x_span, y_span) = (x.end - x.start, y.end - y.start);
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(GRID)
        .axis_style(FRAME)
        .x_labels(12)
        .y_labels(6)
        .x_label_formatter(&|value| tick_label(*value, x_span))
        .y_label_formatter(&|value| tick_label(*value, y_span))
        .label_style(("sans-serif", TEXT_SIZE).into_font().color(&FRAME))
        .axis_desc_style(("sans-serif", TEXT_SIZE).into_font().color(&FRAME))
        .x_desc(if has_x_axis { panel.x_label.as_str() } else { "" })
        .y_desc(&panel.y_label)
        .draw()?;
    for (series, colour) in inked(panel) {
        draw_series(&mut chart, series, colour, x, &y, budget)?;
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
    if series.mark == Mark::Points {
        let points = decimate::cloud(&series.points, x, y, budget.dots);
        chart.draw_series(points.into_iter().map(|point| Circle::new(point, DOT_RADIUS, dot(colour))))?;
    } else if series.mark == Mark::Bars {
        let width = f64::from(chart.plotting_area().dim_in_pixel().0);
        let end = BAR_END * (x.end - x.start) / width;
        let pieces = series.points.chunks_exact(2).filter(|bar| bar.iter().all(is_shown)).flat_map(|bar| {
            let [(at, low), (_, high)] = [bar[0], bar[1]];
            [
                vec![(at, low), (at, high)],
                vec![(at - end, low), (at + end, low)],
                vec![(at - end, high), (at + end, high)],
            ]
        });
        chart.draw_series(pieces.map(|piece| PathElement::new(piece, stroke(colour))))?;
    } else {
        let mut pieces = decimate::curve(&series.points, x, budget.columns);
        if series.mark == Mark::Step {
            pieces = pieces.iter().map(|piece| held(piece)).collect();
        }
        let (width, height) = chart.plotting_area().dim_in_pixel();
        let scale = (f64::from(width) / (x.end - x.start), f64::from(height) / (y.end - y.start));
        let pieces = pieces.iter().flat_map(|piece| broken(piece, series.stroke, scale));
        chart.draw_series(pieces.map(|piece| PathElement::new(piece, stroke(colour))))?;
    }
    Ok(())
}

/// Length of the sample of a line in the legend, and the space between it and its name.
const SAMPLE: i32 = 28 * UNITS_PER_PIXEL as i32;
const SPACE: i32 = 6 * UNITS_PER_PIXEL as i32;
/// Where a row of the legend begins and ends.
const LEGEND_LEFT: i32 = (MARGIN + Y_AXIS_WIDTH) as i32 + SPACE;
const LEGEND_RIGHT: i32 = (WIDTH - MARGIN) as i32;

/// The rows of a legend, as many as its names need, each name with its place from the left.
fn legend(panel: &Panel) -> Vec<Vec<(&Series, RGBColor, i32)>> {
    let (mut rows, mut left) = (vec![Vec::new()], LEGEND_LEFT);
    for (series, colour) in inked(panel).filter(|(series, _)| !series.name.is_empty()) {
        // The width of text is the viewer's affair; sans-serif letters are rarely wider than this on average.
        let width = SAMPLE + SPACE + series.name.chars().count() as i32 * TEXT_SIZE as i32 * 12 / 20;
        if left + width > LEGEND_RIGHT && left > LEGEND_LEFT {
            rows.push(Vec::new());
            left = LEGEND_LEFT;
        }
        rows.last_mut().into_iter().for_each(|row| row.push((series, colour, left)));
        left += width + 3 * SPACE;
    }
    rows
}

/// Names the series above the axes, where it hides no data; gives the area that is left.
fn draw_legend<'a>(area: &Area<'a>, panel: &Panel) -> Result<Area<'a>, Box<dyn std::error::Error>> {
    let mut area = area.clone();
    for row in legend(panel) {
        let (top, below) = area.split_vertically(LEGEND_HEIGHT);
        draw_names(&top, &row)?;
        area = below;
    }
    Ok(area)
}

/// Names series from left to right, each after a sample of its line or dot.
fn draw_names(area: &Area<'_>, row: &[(&Series, RGBColor, i32)]) -> Result<(), Box<dyn std::error::Error>> {
    let middle = LEGEND_HEIGHT as i32 / 2;
    let font = ("sans-serif", TEXT_SIZE).into_font().color(&FRAME).pos(Pos::new(HPos::Left, VPos::Center));
    for &(series, colour, left) in row {
        if series.mark == Mark::Points {
            area.draw(&Circle::new((left + SAMPLE / 2, middle), DOT_RADIUS, dot(colour)))?;
        } else if series.mark == Mark::Bars {
            let (at, half, end) = (left + SAMPLE / 2, LEGEND_HEIGHT as i32 / 3, BAR_END as i32);
            for bar in [
                vec![(at, middle - half), (at, middle + half)],
                vec![(at - end, middle - half), (at + end, middle - half)],
                vec![(at - end, middle + half), (at + end, middle + half)],
            ] {
                area.draw(&PathElement::new(bar, stroke(colour)))?;
            }
        } else {
            let (from, to) = (f64::from(left), f64::from(left + SAMPLE));
            for piece in broken(&[(from, 0.0), (to, 0.0)], series.stroke, (1.0, 1.0)) {
                let piece: Vec<_> = piece.iter().map(|(along, _)| (*along as i32, middle)).collect();
                area.draw(&PathElement::new(piece, stroke(colour)))?;
            }
        }
        area.draw(&Text::new(series.name.as_str(), (left + SAMPLE + SPACE, middle), font.clone()))?;
    }
    Ok(())
}

fn stroke(colour: RGBColor) -> ShapeStyle {
    colour.stroke_width(UNITS_PER_PIXEL + UNITS_PER_PIXEL / 2)
}

fn dot(colour: RGBColor) -> ShapeStyle {
    colour.mix(0.7).filled()
}

/// Points that hold each value until the next x.
fn held(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let corners = points.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    corners.chain(points.last().copied()).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::Stroke;
    use super::*;

    /// The value of an attribute of a piece of SVG.
    fn attribute<'a>(element: &'a str, name: &str) -> &'a str {
        element.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap()
    }

    /// Colour and width of each horizontal line of this figure at more than 1 px, with its y, its first x and its length.
    fn lines(svg: &str, colour: &str) -> Vec<(String, i32, i32, i32)> {
        let lines =
            svg.split("<polyline").skip(1).filter(|line| attribute(line, "stroke").eq_ignore_ascii_case(colour));
        let line = |line: &str| {
            let points: Vec<(i32, i32)> = attribute(line, "points")
                .split_whitespace()
                .map(|point| point.split_once(',').map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())).unwrap())
                .collect();
            let (first, last) = (points[0], points[points.len() - 1]);
            (attribute(line, "stroke-width").to_owned(), first.1, first.0, last.0 - first.0)
        };
        lines.map(line).collect()
    }

    #[test]
    fn the_sample_of_a_legend_is_of_the_colour_width_and_dashes_of_its_line() {
        for (ink, colour) in [(Ink::Nominal, "#D55E00"), (Ink::Improved, "#0072B2"), (Ink::ByPlace, "#0072B2")] {
            for stroke in [Stroke::Solid, Stroke::Dashed, Stroke::Dotted, Stroke::DashDot] {
                let series = Series::new("curve", Mark::Line, [(0.0, 0.5), (1.0, 0.5)]).with(stroke).inked(ink);
                let panels = vec![Panel::new("x", "y", vec![series])];
                let svg = Figure { title: "t".to_owned(), panels }.to_svg().unwrap();
                let lines = lines(&svg, colour);
                let top = lines.iter().map(|line| line.1).min().unwrap();
                let (sample, curve): (Vec<_>, Vec<_>) = lines.iter().partition(|line| line.1 == top);
                assert!(!sample.is_empty() && curve.len() >= sample.len(), "{ink:?}, {stroke:?}: {svg}");
                assert!(lines.iter().all(|line| line.0 == lines[0].0), "one width: {lines:?}");
                // The pieces of the sample lie as the first ones of the curve do; the last is cut where the sample ends.
                let places = |of: &[&(String, i32, i32, i32)]| -> Vec<(i32, i32)> {
                    of.iter().map(|line| (line.2 - of[0].2, line.3)).collect()
                };
                let whole = sample.len() - 1;
                for (one, other) in places(&sample[..whole]).iter().zip(places(&curve[..whole])) {
                    let near = (one.0 - other.0).abs() <= 1 && (one.1 - other.1).abs() <= 1;
                    assert!(near, "{ink:?}, {stroke:?}: {sample:?} {curve:?}");
                }
                assert_eq!(whole > 0, stroke != Stroke::Solid, "{stroke:?}");
            }
        }
    }

    /// L, a, b of a colour (CIE 1976, white D65) as an eye without its middle cones sees it (Machado, Oliveira and Fernandes 2009).
    fn seen_without_green(colour: RGBColor) -> [f64; 3] {
        let linear = |level: u8| {
            let level = f64::from(level) / 255.0;
            if level <= 0.040_45 { level / 12.92 } else { ((level + 0.055) / 1.055).powf(2.4) }
        };
        let rgb = [colour.0, colour.1, colour.2].map(linear);
        let times = |matrix: [[f64; 3]; 3], of: [f64; 3]| {
            matrix.map(|row| row.iter().zip(of).map(|(factor, value)| factor * value).sum::<f64>())
        };
        let deuteranopia =
            [[0.367_322, 0.860_646, -0.227_968], [0.280_085, 0.672_501, 0.047_413], [-0.011_820, 0.042_940, 0.968_881]];
        let seen = times(deuteranopia, rgb).map(|level| level.clamp(0.0, 1.0));
        let to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
        let [x, y, z] = times(to_xyz, seen);
        let root = |t: f64| if t > 0.008_856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
        let [x, y, z] = [root(x / 0.9505), root(y), root(z / 1.089)];
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    fn apart(one: RGBColor, other: RGBColor) -> f64 {
        let squares =
            seen_without_green(one).into_iter().zip(seen_without_green(other)).map(|(a, b)| (a - b) * (a - b));
        squares.sum::<f64>().sqrt()
    }

    #[test]
    fn colours_stay_apart_for_who_does_not_tell_red_from_green() {
        // A pure red and green of one lightness are 6 apart then, and 2.3 are just seen (Mahy 1994).
        assert!(apart(RGBColor(220, 0, 0), RGBColor(0, 160, 0)) < 10.0);
        for (index, one) in COLOURS.iter().enumerate() {
            for other in &COLOURS[..index] {
                assert!(apart(*one, *other) > 15.0, "{one:?} and {other:?}: {}", apart(*one, *other));
            }
        }
        for (one, other) in [(RECORDED, NOMINAL), (RECORDED, IMPROVED), (NOMINAL, IMPROVED)] {
            assert!(apart(one, other) > 30.0, "{one:?} and {other:?}: {}", apart(one, other));
        }
    }

    #[test]
    fn a_legend_of_many_names_goes_on_in_another_row() {
        let series = |name: &str| Series::new(name, Mark::Line, [(0.0, 0.0)]);
        let few = Panel::new("x", "y", ["nominal", "", "improved"].map(series).to_vec());
        assert_eq!(legend(&few).iter().map(Vec::len).collect::<Vec<_>>(), [2]);
        let many = Panel::new("x", "y", ["a name of thirty characters long"; 5].map(series).to_vec());
        let rows = legend(&many);
        // Some 280 pixels each, of 800.
        assert_eq!(rows.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, 1]);
        assert!(rows.iter().all(|row| row[0].2 == LEGEND_LEFT));
    }
}
